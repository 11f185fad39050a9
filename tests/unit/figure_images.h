#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "harness/figures/colour_maps.h"
#include "renderers/scene/image.h"

namespace occlab {

inline constexpr float infinity = std::numeric_limits<float>::infinity();
inline constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();

inline DisplayColour colour_at(const Image& image, int x, int y) {
  return {image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
}

inline void set(Image& image, int x, int y, const DisplayColour& colour) {
  std::ranges::copy(colour, image.pixel(x, y).begin());
}

inline void expect_colour(const DisplayColour& actual, const DisplayColour& expected) {
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(actual[c], expected[c], 1e-6f) << "channel " << c;
}

inline DisplayColour bytes(int red, int green, int blue) {
  return {float(red) / 255.0f, float(green) / 255.0f, float(blue) / 255.0f};
}

}  // namespace occlab
