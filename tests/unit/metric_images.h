// Small images for the tests of the metrics, and their values by name.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <limits>
#include <map>
#include <random>
#include <string>

#include "harness/metrics/metrics.h"

namespace occlab::metrics_test {

inline constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
inline constexpr float infinite = std::numeric_limits<float>::infinity();

struct Colour {
  float r, g, b;
};

inline Image row_of(std::initializer_list<Colour> colours) {
  Image image(static_cast<int>(colours.size()), 1, 3);
  int x = 0;
  for (const Colour& c : colours) {
    image.at(x, 0, 0) = c.r;
    image.at(x, 0, 1) = c.g;
    image.at(x, 0, 2) = c.b;
    ++x;
  }
  return image;
}

inline Image greys(std::initializer_list<float> values) {
  Image image(static_cast<int>(values.size()), 1, 3);
  int x = 0;
  for (const float v : values) {
    for (int c = 0; c < 3; ++c) image.at(x, 0, c) = v;
    ++x;
  }
  return image;
}

inline Image scalars(std::initializer_list<float> values) {
  Image image(static_cast<int>(values.size()), 1, 1);
  int x = 0;
  for (const float v : values) image.at(x++, 0) = v;
  return image;
}

inline Image all_of(const Image& like) { return {like.width(), like.height(), 1, 1.0f}; }

inline Image noise_image(int width, int height, unsigned seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<float> value(0.05f, 2.0f);
  Image image(width, height, 3);
  for (float& v : image.values()) v = value(engine);
  return image;
}

// Foreground with holes and a border that is not straight.
inline Image ragged_mask(int width, int height) {
  Image mask(width, height, 1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) mask.at(x, y) = (x * 7 + y * 5) % 43 > 1 && x > 1 ? 1.0f : 0.5f;
  }
  return mask;
}

inline std::map<std::string, MetricValue> by_name(const ComparisonInput& input) {
  std::map<std::string, MetricValue> result;
  for (const MetricValue& value : measure(input)) result[value.name] = value;
  return result;
}

inline double value_of(const ComparisonInput& input, const std::string& name) {
  const MetricValue value = by_name(input).at(name);
  EXPECT_TRUE(value.value.has_value()) << name << ": " << value.reason;
  return value.value.value_or(std::nan(""));
}

}  // namespace occlab::metrics_test
