#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "harness/figures/colour_maps.h"
#include "harness/figures/tone_map.h"
#include "renderers/scene/error.h"
#include "tests/unit/figure_images.h"

namespace occlab {
namespace {

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

}  // namespace
}  // namespace occlab
