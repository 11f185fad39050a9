#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "renderers/scene/environment.h"

namespace occlab::test {

inline constexpr double pi_d = std::numbers::pi;

/// Direction of a position in texels, from the image's corner.
inline glm::dvec3 texel_direction(const Image& texels, double x, double y) {
  const double theta = pi_d * y / texels.height();
  const double phi = 2.0 * pi_d * (x / texels.width() - 0.5);
  return {std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)};
}

inline glm::dvec3 centre(const Image& texels, int x, int y) {
  return texel_direction(texels, x + 0.5, y + 0.5);
}

/// Sum of radiance times solid angle, red channel.
inline double energy(const Image& texels) {
  double sum = 0.0;
  for (int y = 0; y < texels.height(); ++y) {
    for (int x = 0; x < texels.width(); ++x) {
      sum += double(texels.at(x, y)) * texel_solid_angle(texels, y);
    }
  }
  return sum;
}

/// An equirect image whose channels are all value(x, y).
inline Image grey(int width, const std::function<double(int, int)>& value) {
  Image image(width, width / 2, 3);
  for (int y = 0; y < width / 2; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto v = float(value(x, y));
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = v;
    }
  }
  return image;
}

/// Texels over five decades, some of them black, as a probe with a sun has.
inline Image rough_image(int width, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> exponent(-2.0, 3.0);
  return grey(width, [&](int, int) {
    const double e = exponent(generator);
    return e < -1.5 ? 0.0 : std::pow(10.0, e);
  });
}

}  // namespace occlab::test
