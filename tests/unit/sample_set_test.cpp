// The sample set that all screen-space methods share: what is exact in it, and what is uniform over
// seeds.

#include "renderers/methods/sample_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "harness/statistics.h"

namespace occlab {
namespace {

constexpr double family_level = 1e-6;
constexpr int family_tests = 200;  ///< more than there are in this file

constexpr double two_pi = 2.0 * std::numbers::pi;
double turn_of(double y, double x) {
  const double turn = std::atan2(y, x) / two_pi;
  return turn < 0.0 ? turn + 1.0 : turn;
}

/// Whether values of [0, 1) are uniform, by the means of their first harmonics and their mean:
/// cos(2 pi k u) has mean 0 and variance 1/2, u has mean 1/2 and variance 1/12.
void expect_uniform(const std::vector<double>& values, const std::string& what) {
  const double n = double(values.size());
  double sum = 0.0;
  for (const double u : values) {
    EXPECT_GE(u, 0.0);
    EXPECT_LE(u, 1.0);
    sum += u;
  }
  EXPECT_TRUE(z_test(sum / n, 0.5, std::sqrt(1.0 / (12.0 * n)), family_level, family_tests).passes)
      << what;
  for (int k = 1; k <= 3; ++k) {
    double cosine = 0.0, sine = 0.0;
    for (const double u : values) {
      cosine += std::cos(two_pi * k * u);
      sine += std::sin(two_pi * k * u);
    }
    const double error = std::sqrt(0.5 / n);
    EXPECT_TRUE(z_test(cosine / n, 0.0, error, family_level, family_tests).passes) << what << k;
    EXPECT_TRUE(z_test(sine / n, 0.0, error, family_level, family_tests).passes) << what << k;
  }
}

TEST(SampleSet, HeightsAreStratifiedDirectionsUnitOffsetsInRange) {
  for (const int n : {1, 2, 7, 32, 100, 256}) {
    for (const std::uint64_t seed : {0ULL, 5ULL, 1ULL << 40}) {
      const SampleSet set = make_sample_set(n, seed);
      ASSERT_EQ(set.directions.size(), std::size_t(n));
      double sum = 0.0;
      for (int i = 0; i < n; ++i) {
        const glm::dvec4 s(set.directions[std::size_t(i)]);
        EXPECT_NEAR(s.z, (i + 0.5) / n, 1.51 / n) << "within its ring's stratum";
        EXPECT_NEAR(s.x * s.x + s.y * s.y + s.z * s.z, 1.0, 1e-6);
        EXPECT_GE(s.w, 0.0);
        EXPECT_LT(s.w, 1.0);
        sum += s.z;
      }
      EXPECT_NEAR(sum, 0.5 * n, 1e-6 * n) << "an open plane has an ambient occlusion of 1";
      for (const glm::vec4& turned : set.sets) {
        EXPECT_NEAR(std::hypot(double(turned.x), double(turned.y)), 1.0, 1e-6);
        EXPECT_GE(turned.z, 0.0f);
        EXPECT_LT(turned.z, 1.0f);
      }
    }
  }
}

TEST(SampleSet, OffsetsAreStratified) {
  // One in each N-th of a step, in an order of their own.
  const int n = 64;
  const SampleSet set = make_sample_set(n, 3);
  std::vector<double> offsets;
  for (const glm::vec4& s : set.directions) offsets.push_back(double(s.w));
  EXPECT_FALSE(std::ranges::is_sorted(offsets));
  std::ranges::sort(offsets);
  for (int i = 0; i < n; ++i) EXPECT_EQ(int(offsets[std::size_t(i)] * n), i);
}

TEST(SampleSet, SixteenTurnsAndShiftsAreStratified) {
  for (const std::uint64_t seed : {0ULL, 1ULL, 77ULL}) {
    const SampleSet set = make_sample_set(8, seed);
    std::vector<double> turns, shifts;
    for (const glm::vec4& turned : set.sets) {
      turns.push_back(turn_of(double(turned.y), double(turned.x)));
      shifts.push_back(double(turned.z));
    }
    for (std::vector<double>* values : {&turns, &shifts}) {
      EXPECT_FALSE(std::ranges::is_sorted(*values)) << "neighbours would turn by the same step";
      std::ranges::sort(*values);
      for (std::size_t i = 1; i < 16; ++i) {
        EXPECT_NEAR((*values)[i] - (*values)[i - 1], 1.0 / 16.0, 1e-6);
      }
    }
  }
}

TEST(SampleSet, RingsAreOfOneHeightAndEvenInAzimuth) {
  const std::vector<std::pair<int, std::size_t>> heights = {
      {1, 1}, {8, 8}, {15, 15}, {16, 8}, {17, 9}, {31, 16}, {32, 8}, {33, 33}, {256, 256}};
  for (const auto& [n, rings] : heights) {
    const SampleSet set = make_sample_set(n, 3);
    EXPECT_EQ(sample_rings(n).size(), rings) << n;
    int next = 0;
    for (const SampleRing& ring : sample_rings(n)) {
      EXPECT_EQ(ring.first, next);
      next += ring.count;
      const glm::dvec4 first(set.directions[std::size_t(ring.first)]);
      for (int k = 0; k < ring.count; ++k) {
        const glm::dvec4 s(set.directions[std::size_t(ring.first) + std::size_t(k)]);
        EXPECT_EQ(s.z, first.z);
        const double apart = turn_of(s.y, s.x) - turn_of(first.y, first.x);
        EXPECT_NEAR(apart - std::floor(apart + 1e-4), double(k) / ring.count, 1e-6);
      }
    }
    EXPECT_EQ(next, n);
  }
}

TEST(SampleSet, NoTurnRepeatsAnother) {
  // Over all sets, N = 8, 16 and 32 directions of rings have 16 N azimuths, evenly spaced.
  for (const int n : {8, 16, 17, 32}) {
    const SampleSet set = make_sample_set(n, 5);
    const SampleRing ring = sample_rings(n).front();
    std::vector<double> azimuths;
    for (const glm::vec4& turn : set.sets) {
      for (int k = 0; k < ring.count; ++k) {
        const glm::dvec4 s(set.directions[std::size_t(ring.first) + std::size_t(k)]);
        const glm::dvec4 t(turn);
        azimuths.push_back(turn_of(t.y * s.x + t.x * s.y, t.x * s.x - t.y * s.y));
      }
    }
    std::ranges::sort(azimuths);
    const bool whole = n % ring.count == 0;
    for (std::size_t i = 1; whole && i < azimuths.size(); ++i) {
      EXPECT_NEAR(azimuths[i] - azimuths[i - 1], 1.0 / double(azimuths.size()), 1e-6) << n;
    }
    // The direction that is left over goes all the way round.
    std::vector<double> turns;
    for (const glm::vec4& turn : set.sets) {
      turns.push_back(turn_of(double(turn.y), double(turn.x)));
    }
    std::ranges::sort(turns);
    EXPECT_NEAR(turns.back() - turns.front(), 15.0 / 16.0 / (whole ? ring.count : 1), 0.07) << n;
  }
}

TEST(SampleSet, AzimuthsAndOffsetsAreUniformOverSeeds) {
  constexpr int seeds = 4000;
  const int n = 5;
  std::vector<std::vector<double>> azimuths(n), offsets(n);
  std::vector<double> first, second;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const SampleSet set = make_sample_set(n, seed);
    const glm::dvec4 pixel(set.sets[3]);
    for (std::size_t i = 0; i < n; ++i) {
      const glm::dvec4 s(set.directions[i]);
      const glm::dvec2 at(pixel.x * s.x - pixel.y * s.y, pixel.y * s.x + pixel.x * s.y);
      azimuths[i].push_back(turn_of(at.y, at.x));
      const double offset = s.w + pixel.z;
      offsets[i].push_back(offset - std::floor(offset));
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    expect_uniform(azimuths[i], "azimuth " + std::to_string(i) + " harmonic ");
    expect_uniform(offsets[i], "offset " + std::to_string(i) + " harmonic ");
  }
  // Azimuth and offset of a direction are independent of each other.
  double covariance = 0.0;
  for (std::size_t i = 0; i < seeds; ++i) {
    covariance += (azimuths[2][i] - 0.5) * (offsets[2][i] - 0.5) / seeds;
  }
  EXPECT_TRUE(
      z_test(covariance, 0.0, 1.0 / (12.0 * std::sqrt(seeds)), family_level, family_tests).passes);
}

TEST(SampleSet, AzimuthsOfOneSetAreSpread) {
  // The golden ratio leaves no gap of more than about 1.6 parts in N (three-distance theorem: at
  // most 2.62/N).
  for (const int n : {13, 26, 32, 84}) {
    const SampleSet set = make_sample_set(n, 11);
    std::vector<double> azimuths;
    for (const glm::vec4& s : set.directions) {
      azimuths.push_back(turn_of(double(s.y), double(s.x)));
    }
    std::ranges::sort(azimuths);
    double widest = azimuths.front() + 1.0 - azimuths.back();
    for (std::size_t i = 1; i < azimuths.size(); ++i) {
      widest = std::max(widest, azimuths[i] - azimuths[i - 1]);
    }
    EXPECT_LT(widest, 2.62 / n) << n;
  }
}

TEST(SampleSet, TheSeedTurnsAndShifts) {
  const SampleSet set = make_sample_set(16, 42);
  EXPECT_EQ(set.sets, make_sample_set(16, 42).sets);
  for (const std::uint64_t other : {43ULL, 42ULL + (1ULL << 32)}) {
    EXPECT_EQ(set.directions, make_sample_set(16, other).directions);
    EXPECT_NE(set.sets, make_sample_set(16, other).sets);
  }
}

TEST(SampleSet, SeedZeroIsPinned) {
  // The random numbers are specified to the bit (std::mt19937_64, and its first value for seed 0 is
  // 2947667278772165694); only cosines are left to the library.
  std::mt19937_64 random(0);
  EXPECT_EQ(random(), 2947667278772165694ULL);
  const SampleSet set = make_sample_set(4, 0);
  EXPECT_NEAR(turn_of(double(set.directions[1].y), double(set.directions[1].x)),
              1.0 / std::numbers::phi, 1e-6);
  random.discard(29);  // two orders of 16, of which the first takes a value for each swap
  const double turn_shift = double(random() >> 11) * 0x1p-53;
  const double in_sixteenth = 16.0 * turn_of(double(set.sets[0].y), double(set.sets[0].x));
  EXPECT_NEAR(in_sixteenth - std::floor(in_sixteenth), turn_shift, 1e-5);
}

}  // namespace
}  // namespace occlab
