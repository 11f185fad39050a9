#include "renderers/methods/sample_set.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

namespace occlab {
namespace {

/// Uniform in [0, 1), the same on every standard library.
double uniform(std::mt19937_64& random) { return double(random() >> 11) * 0x1p-53; }

std::vector<int> permutation(std::size_t count, std::mt19937_64& random) {
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t i = count; i > 1; --i) {
    std::swap(order[i - 1], order[std::size_t(uniform(random) * double(i))]);
  }
  return order;
}

double fraction(double value) { return value - std::floor(value); }

}  // namespace

SampleSet make_sample_set(int sample_count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  SampleSet set;
  const auto count = std::size_t(sample_count);
  const double azimuth_shift = uniform(random);
  const std::vector<int> offset_order = permutation(count, random);
  for (std::size_t i = 0; i < count; ++i) {
    const double z = (double(i) + 0.5) / double(count);
    const double radius = std::sqrt(1.0 - z * z);
    const double azimuth =
        2.0 * std::numbers::pi * fraction(double(i) / std::numbers::phi + azimuth_shift);
    const double offset = (double(offset_order[i]) + uniform(random)) / double(count);
    set.directions.emplace_back(radius * std::cos(azimuth), radius * std::sin(azimuth), z, offset);
  }
  const std::vector<int> turn_order = permutation(set.sets.size(), random);
  const std::vector<int> shift_order = permutation(set.sets.size(), random);
  const double turn_shift = uniform(random);
  const double offset_shift = uniform(random);
  for (std::size_t m = 0; m < set.sets.size(); ++m) {
    const double turn = 2.0 * std::numbers::pi * (double(turn_order[m]) + turn_shift) / 16.0;
    const double shift = fraction((double(shift_order[m]) + offset_shift) / 16.0);
    set.sets[m] = glm::vec4(std::cos(turn), std::sin(turn), shift, 0.0);
  }
  return set;
}

}  // namespace occlab
