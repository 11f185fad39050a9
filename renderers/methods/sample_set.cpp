#include "renderers/methods/sample_set.h"

#include <algorithm>
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

glm::dvec2 turned(double turns) {
  return {std::cos(2.0 * std::numbers::pi * turns), std::sin(2.0 * std::numbers::pi * turns)};
}

std::vector<glm::vec4> sample_directions(int sample_count) {
  const auto count = double(sample_count);
  // Any order without a pattern, the same for all seeds.
  std::mt19937_64 random(std::uint64_t(sample_count) + 1);
  const std::vector<int> offset_order = permutation(std::size_t(sample_count), random);
  std::vector<glm::vec4> directions;
  double ring_shift = 0.0;
  for (const SampleRing& ring : sample_rings(sample_count)) {
    const double z = (ring.first + 0.5 * ring.count) / count;  // the middle of the ring's stratum
    const double radius = std::sqrt(1.0 - z * z);
    for (int k = 0; k < ring.count; ++k) {
      const glm::dvec2 xy = radius * turned((k + ring_shift) / ring.count);
      const double offset = (offset_order[directions.size()] + 0.5) / count;
      directions.emplace_back(xy.x, xy.y, z, offset);
    }
    ring_shift = fraction(ring_shift + 1.0 / std::numbers::phi);
  }
  return directions;
}

}  // namespace

std::vector<SampleRing> sample_rings(int sample_count) {
  constexpr int least_heights = 8;
  constexpr int most_in_rings = 32;
  int size = 1;
  while (size < 4 && sample_count <= most_in_rings && sample_count >= 2 * size * least_heights) {
    size *= 2;
  }
  std::vector<SampleRing> rings;
  for (int first = 0; first < sample_count; first += size) {
    rings.push_back({first, std::min(size, sample_count - first)});
  }
  return rings;
}

SampleSet make_sample_set(int sample_count, std::uint64_t seed) {
  SampleSet set{.directions = sample_directions(sample_count), .sets = {}};
  std::mt19937_64 random(seed);
  const std::vector<int> turn_order = permutation(set.sets.size(), random);
  const std::vector<int> shift_order = permutation(set.sets.size(), random);
  const double turn_shift = uniform(random);
  const double offset_shift = uniform(random);
  // Rings that are whole come back to themselves after a part of a turn: more would repeat sets.
  const int in_ring = sample_rings(sample_count).front().count;
  const double range = sample_count % in_ring == 0 ? 1.0 / in_ring : 1.0;
  for (std::size_t m = 0; m < set.sets.size(); ++m) {
    const glm::dvec2 turn = turned(range * (turn_order[m] + turn_shift) / 16.0);
    const double shift = fraction((shift_order[m] + offset_shift) / 16.0);
    set.sets[m] = glm::vec4(turn.x, turn.y, shift, 0.0);
  }
  return set;
}

}  // namespace occlab
