#include "harness/figures/figures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "harness/figures/text.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

DisplayColour colour_at(const Image& image, int x, int y) {
  return {image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
}

void set(Image& image, int x, int y, const DisplayColour& colour) {
  std::ranges::copy(colour, image.pixel(x, y).begin());
}

/// Every pixel another colour, none of them a colour that figures use for something else.
Image gradient(int width, int height, float blue) {
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      set(image, x, y,
          {0.2f + 0.5f * float(x) / float(width), 0.2f + 0.5f * float(y) / float(height), blue});
    }
  }
  return image;
}

bool stands_at(const Image& image, const Image& part, int x0, int y0) {
  for (int y = 0; y < part.height(); ++y) {
    for (int x = 0; x < part.width(); ++x) {
      if (colour_at(image, x0 + x, y0 + y) != colour_at(part, x, y)) return false;
    }
  }
  return true;
}

/// How often `part` occurs in `image`, pixel by pixel.
int occurrences(const Image& image, const Image& part) {
  int count = 0;
  for (int y = 0; y + part.height() <= image.height(); ++y) {
    for (int x = 0; x + part.width() <= image.width(); ++x) {
      if (stands_at(image, part, x, y)) ++count;
    }
  }
  return count;
}

int pixels_of(const Image& image, const DisplayColour& colour) {
  int count = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) count += colour_at(image, x, y) == colour;
  }
  return count;
}

void expect_colour(const DisplayColour& actual, const DisplayColour& expected) {
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(actual[c], expected[c], 1e-6f) << "channel " << c;
}

DisplayColour bytes(int red, int green, int blue) {
  return {float(red) / 255.0f, float(green) / 255.0f, float(blue) / 255.0f};
}

template <typename Call>
std::string input_error(Call&& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no InputError";
  return {};
}

// ---- Tone mapping ------------------------------------------------------------------------------

TEST(ToneMap, ExposesClampsAndEncodesAsSrgb) {
  Image radiance(3, 1, 3);
  set(radiance, 0, 0, {0.25f, 0.0f, -1.0f});
  set(radiance, 1, 0, {0.5f, 7.0f, 0.001f});
  set(radiance, 2, 0, {0.1f, 0.2f, 0.3f});
  const Image display = tone_map(radiance, 2.0, Image(3, 1, 1, 1.0f));
  // IEC 61966-2-1: 0.5 -> 1.055 * 0.5^(1/2.4) - 0.055; below 0.0031308 the factor is 12.92.
  expect_colour(colour_at(display, 0, 0), {0.7353570f, 0.0f, 0.0f});
  expect_colour(colour_at(display, 1, 0), {1.0f, 1.0f, 0.02584f});
  expect_colour(colour_at(display, 2, 0), {float(1.055 * std::pow(0.2, 1 / 2.4) - 0.055),
                                           float(1.055 * std::pow(0.4, 1 / 2.4) - 0.055),
                                           float(1.055 * std::pow(0.6, 1 / 2.4) - 0.055)});
}

TEST(ToneMap, BackgroundIsNeutralGreyAndBrokenPixelsShow) {
  Image radiance(4, 1, 3, 0.5f);
  set(radiance, 1, 0, {1.0f, nan_value, 1.0f});
  set(radiance, 2, 0, {1.0f, 1.0f, infinity});
  set(radiance, 3, 0, {nan_value, 0.0f, 0.0f});
  Image mask(4, 1, 1, 1.0f);
  mask.at(0, 0) = 0.0f;
  mask.at(3, 0) = 0.5f;
  const Image display = tone_map(radiance, 1.0, mask);
  EXPECT_EQ(colour_at(display, 0, 0), figure_background);
  EXPECT_EQ(colour_at(display, 1, 0), not_finite_colour);
  EXPECT_EQ(colour_at(display, 2, 0), not_finite_colour);
  EXPECT_EQ(colour_at(display, 3, 0), figure_background);
}

TEST(ToneMap, RefusesWhatItCannotShow) {
  const Image radiance(4, 2, 3, 1.0f);
  const Image mask(4, 2, 1, 1.0f);
  EXPECT_THROW(tone_map(radiance, 1.0, Image(2, 4, 1, 1.0f)), InputError);
  EXPECT_THROW(tone_map(Image(4, 2, 1), 1.0, mask), InputError);
  EXPECT_THROW(tone_map(radiance, 0.0, mask), InputError);
  EXPECT_THROW(tone_map(radiance, double(infinity), mask), InputError);
}

TEST(SharedExposure, TakesThe99thPercentileLuminanceOverTheMaskToOne) {
  // 101 grey pixels 0, 1, ... 100 times 0.02: the 99th percentile of type 7 is the one at 99.
  Image reference(102, 1, 3);
  Image mask(102, 1, 1, 1.0f);
  for (int x = 0; x <= 100; ++x) {
    const float grey = 0.02f * float(x);
    set(reference, x, 0, {grey, grey, grey});
  }
  set(reference, 101, 0, {1000.0f, 1000.0f, 1000.0f});
  mask.at(101, 0) = 0.0f;
  EXPECT_NEAR(shared_exposure(reference, mask), 1.0 / 1.98, 1e-6);

  // The luminance of Rec.709 weighs the channels.
  Image green(1, 1, 3);
  green.at(0, 0, 1) = 2.0f;
  EXPECT_NEAR(shared_exposure(green, Image(1, 1, 1, 1.0f)), 1.0 / (2 * 0.7152), 1e-9);
}

TEST(SharedExposure, RefusesBlackEmptyAndBrokenReferences) {
  const Image mask(2, 1, 1, 1.0f);
  EXPECT_THROW(shared_exposure(Image(2, 1, 3), mask), InputError);
  EXPECT_THROW(shared_exposure(Image(2, 1, 3, 1.0f), Image(2, 1, 1)), InputError);
  EXPECT_THROW(shared_exposure(Image(2, 1, 3, nan_value), mask), InputError);
  EXPECT_THROW(shared_exposure(Image(2, 1, 3, 1.0f), Image(1, 2, 1, 1.0f)), InputError);
}

// ---- Colour maps -------------------------------------------------------------------------------

TEST(ErrorColour, DivergingScaleIsBlueWhiteRed) {
  const auto colour = [](double error) {
    return error_colour(ErrorMap::signed_luminance, error, 0.5);
  };
  expect_colour(colour(-0.5), bytes(0x05, 0x30, 0x61));
  expect_colour(colour(0.0), bytes(0xf7, 0xf7, 0xf7));
  expect_colour(colour(0.5), bytes(0x67, 0x00, 0x1f));
  expect_colour(colour(0.1), bytes(0xfd, 0xdb, 0xc7));
  const DisplayColour half = {0.5f * (0xf7 + 0xfd) / 255.0f, 0.5f * (0xf7 + 0xdb) / 255.0f,
                              0.5f * (0xf7 + 0xc7) / 255.0f};
  expect_colour(colour(0.05), half);
  EXPECT_EQ(colour(-3.0), colour(-0.5));
  EXPECT_EQ(colour(0.6), colour(0.5));
  EXPECT_EQ(colour(double(nan_value)), not_finite_colour);
  EXPECT_EQ(colour(double(infinity)), not_finite_colour);
}

TEST(ErrorColour, SequentialScaleIsViridis) {
  const auto colour = [](double error) { return error_colour(ErrorMap::rms, error, 2.0); };
  expect_colour(colour(0.0), bytes(0x44, 0x01, 0x54));
  expect_colour(colour(2.0), bytes(0xfd, 0xe7, 0x25));
  // Its 128th and 129th of 256 colours lie on both sides of the middle; the table has every 17th.
  const DisplayColour middle = colour(1.0);
  const DisplayColour published = {0.127f, 0.566f, 0.551f};
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(middle[c], published[c], 0.01f);
  double last = -1.0;
  for (int i = 0; i <= 100; ++i) {
    const DisplayColour c = colour(0.02 * i);
    const double brightness =
        0.2126 * std::pow(c[0], 2.2) + 0.7152 * std::pow(c[1], 2.2) + 0.0722 * std::pow(c[2], 2.2);
    EXPECT_GT(brightness, last) << i;
    last = brightness;
  }
}

TEST(ErrorColour, RefusesAScaleThatIsNotPositive) {
  EXPECT_THROW(error_colour(ErrorMap::rms, 0.0, 0.0), InputError);
  EXPECT_THROW(error_colour(ErrorMap::rms, 0.0, double(nan_value)), InputError);
  EXPECT_THROW(colour_bar(ErrorMap::signed_luminance, -1.0, 10, 1), InputError);
}

TEST(ColourBar, ColumnsAreTheErrorsAtTheirCentres) {
  const Image bar = colour_bar(ErrorMap::signed_luminance, 0.4, 81, 3);
  for (int x = 0; x < 81; ++x) {
    const double error = 0.8 * (x + 0.5) / 81 - 0.4;
    const DisplayColour expected = error_colour(ErrorMap::signed_luminance, error, 0.4);
    for (int y = 0; y < 3; ++y) EXPECT_EQ(colour_at(bar, x, y), expected);
  }
  expect_colour(colour_at(bar, 40, 1), bytes(0xf7, 0xf7, 0xf7));
  EXPECT_EQ(error_scale_ticks(ErrorMap::signed_luminance, 0.5),
            (std::array<double, 5>{-0.5, -0.25, 0.0, 0.25, 0.5}));
  EXPECT_EQ(error_scale_ticks(ErrorMap::rms, 0.5),
            (std::array<double, 5>{0.0, 0.125, 0.25, 0.375, 0.5}));
}

TEST(FrameColours, AreThePapersAndStayWithAName) {
  const auto strongest = [](const DisplayColour& colour) {
    return std::ranges::max_element(colour) - colour.begin();
  };
  EXPECT_EQ(strongest(frame_colour(0)), 0);
  EXPECT_EQ(strongest(frame_colour(1)), 1);
  EXPECT_EQ(strongest(frame_colour(2)), 2);
  const std::vector<std::vector<std::string>> figures = {{"a", "b"}, {"c", "b"}, {"a", "d"}};
  const auto colours = frame_colours(figures);
  ASSERT_EQ(colours.size(), 4u);
  EXPECT_EQ(colours.at("a"), frame_colour(0));
  EXPECT_EQ(colours.at("b"), frame_colour(1));
  EXPECT_EQ(colours.at("c"), frame_colour(2));
  EXPECT_EQ(colours.at("d"), frame_colour(3));
}

// ---- Text --------------------------------------------------------------------------------------

TEST(Text, IsDrawnAndWraps) {
  const TextStyle style{20};
  const Image line = text_block("Occlusion", style, 1000);
  EXPECT_GT(pixels_of(line, ink), 50);
  EXPECT_GT(pixels_of(line, paper), 50);
  EXPECT_EQ(line.width(), text_width("Occlusion", style));
  const Image wrapped = text_block("Occlusion Occlusion\nOcclusion", style, line.width() + 5);
  EXPECT_EQ(wrapped.width(), line.width());
  EXPECT_NEAR(wrapped.height(), 3 * line.height(), 3);
  const Image word = text_block("OcclusionOcclusion", style, line.width() + 5);
  EXPECT_LE(word.width(), line.width() + 5);
  EXPECT_GT(word.height(), line.height());
  EXPECT_TRUE(text_block("", style, 100).empty());
}

TEST(Text, CharactersOutsideOfAsciiAreTheirOwn) {
  const TextStyle style{40};
  const Image box = text_block("\U0010fffd", style, 500);
  for (const char* character : {"\u2212", "\u00d7", "\u2264", "\u00e4"}) {
    const Image drawn = text_block(character, style, 500);
    EXPECT_GT(pixels_of(drawn, ink), 10) << character;
    EXPECT_FALSE(drawn == box) << character;
  }
  // A minus sign is one bar; as high above the baseline as that of a plus sign.
  const Image minus = text_block("\u2212", style, 500);
  const Image plus = text_block("+", style, 500);
  int lowest = 0;
  int highest = minus.height();
  for (int y = 0; y < minus.height(); ++y) {
    for (int x = 0; x < minus.width(); ++x) {
      if (minus.at(x, y) == 1.0f) continue;
      lowest = std::max(lowest, y);
      highest = std::min(highest, y);
    }
  }
  EXPECT_LE(lowest - highest, 6);
  EXPECT_LT(plus.at(plus.width() / 2, highest), 0.5f);
  // Bytes that are not UTF-8 are drawn as the replacement character, one each.
  EXPECT_EQ(text_block("\xff", style, 500), text_block("\ufffd", style, 500));
  EXPECT_EQ(text_block("\xe2\x88", style, 500), text_block("\ufffd\ufffd", style, 500));
}

// ---- Figures -----------------------------------------------------------------------------------

TEST(ComparisonFigure, ShowsEveryPixelOfEveryPanelInItsColour) {
  ComparisonFigure figure{"Title", {}, "A caption."};
  for (std::size_t i = 0; i < 3; ++i) {
    figure.panels.push_back({"P", frame_colour(i), gradient(160, 90, 0.1f * float(i + 1))});
  }
  const Image drawn = comparison_figure(figure);
  EXPECT_EQ(drawn.channels(), 3);
  for (const Panel& panel : figure.panels) {
    EXPECT_EQ(occurrences(drawn, panel.image), 1);
    EXPECT_GT(pixels_of(drawn, panel.colour), 2 * (160 + 90) * 3);
  }
  EXPECT_EQ(pixels_of(drawn, frame_colour(3)), 0);
  // Title and caption are drawn, and take room.
  ComparisonFigure silent = figure;
  silent.title.clear();
  silent.caption.clear();
  const Image without = comparison_figure(silent);
  EXPECT_GT(pixels_of(drawn, ink), pixels_of(without, ink) + 100);
  EXPECT_GT(drawn.height(), without.height() + 2 * 16);
}

TEST(ComparisonFigure, RefusesWhatDoesNotFit) {
  EXPECT_THROW(comparison_figure({}), InputError);
  const DisplayColour colour = frame_colour(0);
  ComparisonFigure figure{"", {{"A", colour, Image(8, 4, 3)}, {"Odd", colour, Image(4, 8, 3)}}, ""};
  EXPECT_NE(input_error([&] { comparison_figure(figure); }).find("Odd"), std::string::npos);
  figure.panels[1].image = Image(8, 4, 1);
  EXPECT_THROW(comparison_figure(figure), InputError);
  figure.panels[1].image = Image(8, 4, 3, 1.5f);
  EXPECT_THROW(comparison_figure(figure), InputError);
  figure.panels[1].image = Image(8, 4, 3, nan_value);
  EXPECT_THROW(comparison_figure(figure), InputError);
  figure.panels[1].image = Image(8, 4, 3, 1.0f);
  EXPECT_NO_THROW(comparison_figure(figure));
}

TEST(Crop, RepeatsThePixelsOfTheRectangle) {
  const Image image = gradient(32, 24, 0.3f);
  const Rectangle rectangle{5, 7, 6, 4};
  const Image closeup = crop(image, rectangle, 3);
  ASSERT_EQ(closeup.width(), 18);
  ASSERT_EQ(closeup.height(), 12);
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 18; ++x) {
      EXPECT_EQ(colour_at(closeup, x, y), colour_at(image, 5 + x / 3, 7 + y / 3));
    }
  }
  EXPECT_EQ(crop(image, {0, 0, 32, 24}), image);
}

TEST(Crop, RefusesRectanglesOutsideOfTheFrame) {
  const Image image(32, 24, 3);
  const int huge = std::numeric_limits<int>::max();
  for (const Rectangle& bad : {Rectangle{-1, 0, 4, 4},
                               {0, -1, 4, 4},
                               {29, 0, 4, 4},
                               {0, 21, 4, 4},
                               {0, 0, 0, 4},
                               {0, 0, 4, -1},
                               {0, 0, 33, 4},
                               {huge, 0, 4, 4},
                               {4, 0, huge, 4},
                               {0, 4, 4, huge}}) {
    EXPECT_THROW(crop(image, bad, 2), InputError) << bad.x << ' ' << bad.y << ' ' << bad.width;
  }
  EXPECT_THROW(crop(image, {0, 0, 4, 4}, 0), InputError);
  EXPECT_NO_THROW(crop(image, {28, 20, 4, 4}, 1));
}

TEST(DrawRectangles, LeavesTheirInsideAlone) {
  const Image image = gradient(200, 160, 0.3f);
  const Rectangle first{30, 40, 40, 30};
  const Rectangle second{120, 90, 50, 40};
  const Image drawn = draw_rectangles(image, {first, second});
  EXPECT_EQ(crop(drawn, first), crop(image, first));
  EXPECT_EQ(crop(drawn, second), crop(image, second));
  for (const Rectangle& r : {first, second}) {
    EXPECT_EQ(colour_at(drawn, r.x - 1, r.y), ink);
    EXPECT_EQ(colour_at(drawn, r.x + r.width, r.y), ink);
    EXPECT_EQ(colour_at(drawn, r.x + 5, r.y + r.height), ink);
    EXPECT_EQ(colour_at(drawn, r.x + r.width + 1, r.y), paper);
  }
  // Far from both nothing changes; the whole frame may be a rectangle.
  EXPECT_EQ(crop(drawn, {0, 100, 60, 60}), crop(image, {0, 100, 60, 60}));
  EXPECT_NO_THROW(draw_rectangles(image, {{0, 0, 200, 160}}));
  EXPECT_THROW(draw_rectangles(image, {{0, 0, 201, 160}}), InputError);
}

CloseupFigure closeups() {
  CloseupFigure figure;
  figure.title = "Closeups";
  figure.overview = gradient(64, 48, 0.9f);
  figure.columns = {{"A", frame_colour(0)}, {"B", frame_colour(1)}};
  figure.rows = {
      {"one", "N = 32", {10, 5, 12, 8}, {gradient(64, 48, 0.1f), gradient(64, 48, 0.2f)}},
      {"two", "N = 8", {30, 20, 6, 4}, {gradient(64, 48, 0.3f), gradient(64, 48, 0.4f)}}};
  figure.magnification = 4;
  return figure;
}

TEST(CloseupFigure, ShowsTheRectanglesOfEveryImageEnlarged) {
  const CloseupFigure figure = closeups();
  const Image drawn = closeup_figure(figure);
  for (const Image& image : figure.rows[0].images) {
    EXPECT_EQ(occurrences(drawn, crop(image, {10, 5, 12, 8}, 4)), 1);
  }
  // The smaller rectangle fits its cell of 48x32 pixels eight times.
  for (const Image& image : figure.rows[1].images) {
    EXPECT_EQ(occurrences(drawn, crop(image, {30, 20, 6, 4}, 8)), 1);
  }
  CloseupFigure shorter = figure;
  shorter.rows.pop_back();
  EXPECT_GT(drawn.height(), closeup_figure(shorter).height());
}

TEST(CloseupFigure, RefusesWhatDoesNotFit) {
  const auto refused = [](auto change) {
    CloseupFigure figure = closeups();
    change(figure);
    return input_error([&] { closeup_figure(figure); });
  };
  EXPECT_NE(refused([](auto& f) { f.rows[1].rectangle.x = 60; }).find("two"), std::string::npos);
  refused([](auto& f) { f.rows[0].images.pop_back(); });
  refused([](auto& f) { f.rows[0].images[1] = gradient(48, 64, 0.1f); });
  refused([](auto& f) { f.overview = gradient(48, 64, 0.1f); });
  refused([](auto& f) { f.rows.clear(); });
  refused([](auto& f) { f.columns.clear(); });
  refused([](auto& f) { f.magnification = 0; });
  refused([](auto& f) { f.magnification = 17; });
}

TEST(ErrorSummary, IsOverTheFiniteErrorsOfTheMask) {
  Image error(6, 1, 1);
  const float values[] = {0.2f, -0.6f, 0.1f, nan_value, 100.0f, 0.5f};
  std::ranges::copy(values, error.values().begin());
  Image mask(6, 1, 1, 1.0f);
  mask.at(4, 0) = 0.0f;
  const ErrorSummary summary = summarize_error(error, mask, 0.5);
  EXPECT_NEAR(summary.mean, 0.05, 1e-7);
  EXPECT_NEAR(summary.mean_absolute, 0.35, 1e-7);
  EXPECT_EQ(summary.beyond_scale, 0.25);  // -0.6; 0.5 is on the scale
  EXPECT_EQ(summary.not_finite, 1u);

  const ErrorSummary none = summarize_error(Image(6, 1, 1, nan_value), mask, 0.5);
  EXPECT_TRUE(std::isnan(none.mean));
  EXPECT_EQ(none.not_finite, 5u);
  EXPECT_THROW(summarize_error(error, Image(5, 1, 1, 1.0f), 0.5), InputError);
}

TEST(ErrorFigure, ShowsFalseColourOnOneScaleWithItsBar) {
  Image error(160, 90, 1);
  Image mask(160, 90, 1, 1.0f);
  Image expected(160, 90, 3);
  for (int y = 0; y < 90; ++y) {
    for (int x = 0; x < 160; ++x) {
      error.at(x, y) = (float(x) - 80.0f) / 100.0f;
      if (y < 10) mask.at(x, y) = 0.0f;
      const auto shown = error_colour(ErrorMap::signed_luminance, error.at(x, y), 0.25);
      set(expected, x, y, y < 10 ? figure_background : shown);
    }
  }
  Image opposite = error;
  for (float& value : opposite.values()) value = -value;
  ErrorFigure figure;
  figure.scale = 0.25;
  figure.mask = mask;
  figure.panels = {{"A", frame_colour(0), error}, {"B", frame_colour(1), opposite}};
  const Image drawn = error_figure(figure);
  EXPECT_EQ(occurrences(drawn, expected), 1);

  // The bar is half as wide as the two framed maps.
  int bars = 0;
  for (int width = 150; width < 200; ++width) {
    bars += occurrences(drawn, colour_bar(figure.kind, figure.scale, width, 4)) > 0;
  }
  EXPECT_EQ(bars, 1);

  // Another scale is printed with other numbers, another error with another mean.
  ErrorFigure rescaled = figure;
  rescaled.scale = 0.5;
  EXPECT_FALSE(error_figure(rescaled) == drawn);
}

TEST(ErrorFigure, RefusesWhatDoesNotFit) {
  ErrorFigure figure;
  figure.scale = 1.0;
  figure.mask = Image(8, 4, 1, 1.0f);
  EXPECT_THROW(error_figure(figure), InputError);
  figure.panels = {{"A", frame_colour(0), Image(8, 4, 1)}, {"B", frame_colour(1), Image(4, 8, 1)}};
  EXPECT_NE(input_error([&] { error_figure(figure); }).find("B"), std::string::npos);
  figure.panels[1].error = Image(8, 4, 1);
  EXPECT_NO_THROW(error_figure(figure));
  figure.scale = 0.0;
  EXPECT_THROW(error_figure(figure), InputError);
  figure.scale = 1.0;
  figure.mask = Image(8, 4, 1);
  EXPECT_THROW(error_figure(figure), InputError);
}

}  // namespace
}  // namespace occlab
