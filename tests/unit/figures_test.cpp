#include "harness/figures/figures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "harness/figures/text.h"
#include "renderers/scene/error.h"
#include "tests/unit/figure_images.h"

namespace occlab {
namespace {

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
  EXPECT_NE(input_error([&] { error_figure(figure); }).find('B'), std::string::npos);
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
