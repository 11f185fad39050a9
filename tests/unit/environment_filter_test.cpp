// The probe's Gaussian prefilter and SSBN's cone prefilter.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "renderers/scene/environment.h"
#include "renderers/scene/parallel.h"
#include "tests/unit/tiny_probes.h"

namespace occlab {
namespace {

using test::centre;
using test::energy;
using test::grey;
using test::pi_d;
using test::rough_image;

TEST(ResampleArea, KeepsEnergyAndConstants) {
  const Image image = rough_image(60, 3);
  for (const int width : {60, 40, 22, 64, 120, 2}) {
    const Image resampled = resample_area(image, width);
    EXPECT_EQ(resampled.width(), width);
    EXPECT_NEAR(energy(resampled) / energy(image), 1.0, 1e-6) << width;
  }
  const Image same = resample_area(image, 60);
  for (std::size_t i = 0; i < image.values().size(); ++i) {
    EXPECT_NEAR(same.values()[i], image.values()[i], 1e-5f * image.values()[i] + 1e-9f);
  }
}

class GaussianPrefilter : public testing::TestWithParam<float> {};

TEST_P(GaussianPrefilter, KeepsConstantsAndEnergy) {
  const Image constant = prefilter_gaussian(grey(256, [](int, int) { return 3.0; }), GetParam());
  for (const float value : constant.values()) ASSERT_NEAR(value, 3.0f, 2e-5f);
  const Image rough = rough_image(256, 4);
  EXPECT_NEAR(energy(prefilter_gaussian(rough, GetParam())) / energy(rough), 1.0, 5e-6);
}

INSTANTIATE_TEST_SUITE_P(Sigmas, GaussianPrefilter,
                         testing::Values(0.01f, 0.3f, 1.0f, 3.0f, 10.0f, 45.0f, 180.0f));

TEST(GaussianPrefilterShape, ApproachesTheIdentity) {
  const Image image = rough_image(64, 5);
  const Image filtered = prefilter_gaussian(image, 0.05f);
  for (std::size_t i = 0; i < image.values().size(); ++i) {
    // At the poles neighbouring texels' centres are only 0.14 degrees apart.
    const std::size_t row = i / 3 / 64;
    if (row < 2 || row >= 30) continue;
    ASSERT_NEAR(filtered.values()[i], image.values()[i], 1e-5f * image.values()[i]);
  }
}

TEST(GaussianPrefilterShape, ADeltaLightBecomesTheGaussian) {
  // Rows near the equator, at middle latitude and beside the pole; no averaging at this size.
  for (const int row : {127, 60, 2}) {
    constexpr int column = 300;
    Image delta = grey(512, [](int, int) { return 0.0; });
    const double power = 7.0;
    delta.at(column, row) = float(power / texel_solid_angle(delta, row));
    constexpr double sigma = 4.0 * pi_d / 180.0;
    const Image filtered = prefilter_gaussian(delta, 4.0f);
    ASSERT_EQ(filtered.width(), 360);  // 4 pi / sigma = 180 rows
    // Peak of a normalised Gaussian on the sphere: 1 / (2 pi sigma^2 (1 - sigma^2/6 ...)).
    double integral = 0.0;
    constexpr int parts = 4000;
    constexpr double width = 5.0 * sigma / parts;
    for (int i = 0; i < parts; ++i) {
      const double angle = (i + 0.5) * width;
      integral +=
          2.0 * pi_d * std::sin(angle) * std::exp(-angle * angle / (2.0 * sigma * sigma)) * width;
    }
    const double peak = power / integral;
    // Averaging to 1-degree texels first moves the light by up to 0.7 degrees and widens it.
    glm::dvec3 centroid(0.0);
    for (int y = 0; y < 180; ++y) {
      for (int x = 0; x < 360; ++x) {
        centroid +=
            double(filtered.at(x, y)) * texel_solid_angle(filtered, y) * centre(filtered, x, y);
      }
    }
    const glm::dvec3 found = glm::normalize(centroid);
    const glm::dvec3 wanted = centre(delta, column, row);
    EXPECT_LT(std::acos(std::min(1.0, glm::dot(found, wanted))), 0.75 * pi_d / 180.0) << row;
    double largest = 0.0;
    for (int y = 0; y < 180; ++y) {
      for (int x = 0; x < 360; ++x) {
        const double angle =
            std::acos(std::clamp(glm::dot(found, centre(filtered, x, y)), -1., 1.));
        const double expected =
            angle < 5.0 * sigma ? peak * std::exp(-angle * angle / (2.0 * sigma * sigma)) : 0.0;
        largest = std::max(largest, std::abs(double(filtered.at(x, y)) - expected));
      }
    }
    EXPECT_LT(largest, 0.02 * peak) << row;
  }
}

TEST(GaussianPrefilterShape, IsTheSameForEveryThreadCount) {
  const Image image = rough_image(128, 6);
  set_thread_count(1);
  const Image one = prefilter_gaussian(image, 2.0f);
  set_thread_count(5);
  const Image five = prefilter_gaussian(image, 2.0f);
  set_thread_count(0);
  EXPECT_EQ(one, five);
}

TEST(ConePrefilterLevels, KeepConstants) {
  constexpr int levels = 8;
  const ConePrefilter cones = prefilter_cones(constant_environment({1, 2, 3}), levels, 64);
  ASSERT_EQ(cones.levels.size(), std::size_t(levels));
  for (int level = 0; level < levels; ++level) {
    const Image& image = cones.levels[std::size_t(level)];
    ASSERT_EQ(image.width(), 64);
    ASSERT_EQ(image.height(), 32);
    const double alpha = 0.5 * pi_d * (level + 1) / levels;
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 64; ++x) {
        for (int c = 0; c < 3; ++c) {
          ASSERT_NEAR(image.at(x, y, c), (c + 1) * (1.0 + std::cos(alpha)), 2e-5 * (c + 1));
        }
      }
    }
  }
}

TEST(ConePrefilterLevels, MatchTheStepSky) {
  // L = 1 above the horizon, 0 below. Within a cone of half-angle alpha about elevation e the
  // projected area above the horizon is a disc of radius sin alpha cut by the ellipse that the
  // horizon projects to: integrated numerically in the cone's own frame here.
  constexpr int levels = 8;
  Environment environment;
  environment.texels = grey(256, [](int, int y) { return y < 64 ? 1.0 : 0.0; });
  const ConePrefilter cones = prefilter_cones(environment, levels, 128);
  for (int level = 0; level < levels; ++level) {
    const double alpha = 0.5 * pi_d * (level + 1) / levels;
    const Image& image = cones.levels[std::size_t(level)];
    for (int y = 0; y < image.height(); ++y) {
      const double elevation = pi_d * (0.5 - (y + 0.5) / image.height());
      double sum = 0.0;
      constexpr int steps = 2000;
      for (int i = 0; i < steps; ++i) {
        // Azimuth phi about the axis, measured from "up": a direction at angle t from the axis has
        // height sin e cos t + cos e sin t cos phi, > 0 for t on one side of a bound.
        const double t = alpha * (i + 0.5) / steps;
        const double a = std::sin(elevation) * std::cos(t);
        const double b = std::cos(elevation) * std::sin(t);
        const double lit = std::acos(std::clamp(-a / b, -1.0, 1.0)) / pi_d;
        sum += 2.0 * pi_d * lit * std::cos(t) * std::sin(t) * alpha / steps;
      }
      const double expected = sum / (pi_d * (1.0 - std::cos(alpha)));
      // Two texels of 2.8 degrees lie across the smallest cone's radius of 11 degrees.
      EXPECT_NEAR(image.at(5, y), expected, 0.02) << "level " << level << " row " << y;
    }
  }
}

}  // namespace
}  // namespace occlab
