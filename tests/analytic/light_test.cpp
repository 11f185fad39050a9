// The ray tracer's light against closed forms, its estimators against each other, and its stated
// variance against what it claims to be.

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "renderers/scene/parallel.h"
#include "tests/analytic/built_scenes.h"
#include "tests/analytic/traced_points.h"

namespace occlab::test {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();
constexpr Estimator all_estimators[] = {Estimator::mis, Estimator::cosine, Estimator::environment};

Scene floor_and_wall(float size = 1.5f) {
  return SceneBuilder()
      .add(quad({0, -size, 0}, {size, 0, 0}, {0, 2 * size, 0}))
      .add(quad({0, -size, 0}, {0, 2 * size, 0}, {0, 0, size}))
      .build();
}

Scene far_away() { return SceneBuilder().add(quad({-1, -50, -1}, {2, 0, 0}, {0, 0, 2})).build(); }

Mean channel(const PointReplicates& of, int c = 0) { return mean_of(of.radiance[c]); }

TEST(TracedLight, UniformSkyGivesReflectanceTimesVisibility) {
  const Scene scene = floor_and_wall();
  const glm::vec3 rho(0.2f, 0.5f, 0.9f), sky(3.0f, 1.0f, 0.5f);
  for (const Estimator estimator : all_estimators) {
    const auto of = trace_points(scene, constant_environment(sky), {{{0.25, 0, 0}, {0, 0, 1}, rho}},
                                 {.estimator = estimator, .d_max_world = 1.0f});
    for (int c = 0; c < 3; ++c) {
      const double unit = double(rho[c] * sky[c]);
      EXPECT_TRUE(agrees(channel(of[0], c), unit * 0.657481, 1e-5)) << int(estimator);
      if (estimator == Estimator::cosine) {
        // Sample by sample the light of a uniform sky is the visibility.
        for (std::size_t i = 0; i < of[0].ambient_occlusion.size(); ++i) {
          EXPECT_NEAR(of[0].radiance[c][i], unit * of[0].ambient_occlusion[i], 1e-5);
        }
      }
    }
  }
}

TEST(TracedLight, FurnaceStaysExactForMillionsOfRays) {
  // Sums of so many equal terms are where single precision would drift.
  const auto of = trace_points(
      far_away(), constant_environment(glm::vec3(1.0f)), {{}},
      {.rays_per_pixel = 1L << 20, .estimator = Estimator::cosine, .d_max_world = 1.0f}, 1);
  for (const double radiance : of[0].radiance[0]) EXPECT_NEAR(radiance, 1.0, 2e-6);
  for (const double k : of[0].ambient_occlusion) EXPECT_EQ(k, 1.0);
}

TEST(TracedLight, BlackSkyIsBlackWithEveryEstimator) {
  const Light sun{.name = "sun",
                  .type = LightType::directional,
                  .direction_world = {0, 0, -1},
                  .intensity = glm::vec3(2.0f)};
  for (const Estimator estimator : all_estimators) {
    const TraceSettings settings{.estimator = estimator, .d_max_world = 1.0f};
    const std::vector<Point> points = {{{0.25, 0, 0}}};
    const Environment black = constant_environment(glm::vec3(0.0f));
    const auto dark = trace_points(floor_and_wall(), black, points, settings, 4);
    const auto sunlit = trace_points(floor_and_wall(), black, points, settings, 4, {sun});
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(dark[0].radiance[0][i], 0.0) << int(estimator);
      EXPECT_NEAR(sunlit[0].radiance[0][i], 2.0 / pi_d, 1e-6) << int(estimator);
      EXPECT_EQ(sunlit[0].reported_variance[0][i], 0.0);
    }
    if (estimator != Estimator::environment) {
      EXPECT_TRUE(agrees(mean_of(dark[0].ambient_occlusion), 0.657481, 2e-3));
    }
  }
}

TEST(TracedLight, EstimatorsAgreeUnderAnHdrProbe) {
  const Environment probe = load_environment({.source = "cathedral"});
  const Scene scene = floor_and_wall();
  const std::vector<Point> points = {
      {{0.25, 0, 0}, {0, 0, 1}}, {{0, 0.3, 0.25}, {1, 0, 0}}, {{1, 1, 0}, {0, 0, 1}}};
  const auto trace = [&](Estimator estimator) {
    return trace_points(
        scene, probe, points,
        {.rays_per_pixel = 4096, .estimator = estimator, .seed = 5, .d_max_world = 1.0f}, 256);
  };
  const auto mis = trace(Estimator::mis);
  const auto cosine = trace(Estimator::cosine);
  const auto environment = trace(Estimator::environment);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_TRUE(agree(channel(mis[i], c), channel(cosine[i], c))) << i << " " << c;
      EXPECT_TRUE(agree(channel(mis[i], c), channel(environment[i], c))) << i << " " << c;
    }
    EXPECT_LT(channel(mis[i]).standard_error, channel(cosine[i]).standard_error)
        << "importance sampling is of use";
    EXPECT_TRUE(agree(mean_of(mis[i].ambient_occlusion), mean_of(cosine[i].ambient_occlusion)));
  }
  EXPECT_TRUE(trace_points(scene, probe, points, {.estimator = Estimator::environment}, 1)[0]
                  .ambient_occlusion.empty());
}

TEST(TracedLight, TheCameraAndTheProbesRotationAreUndone) {
  // The same world seen by a turned camera, and a probe turned against its texels.
  const Scene scene = floor_and_wall();
  const TracedScene traced(scene);
  const auto sky = [](glm::vec3 d) { return glm::vec3(1 + d.x, 1 + d.y, 1 + d.z); };
  const glm::mat3 turn(glm::rotate(glm::mat4(1.0f), 1.1f, glm::normalize(glm::vec3(1, 2, -1))));
  Environment turned = probe_of(128, [&](glm::vec3 d) { return sky(glm::transpose(turn) * d); });
  turned.probe_from_world = turn;

  View view;
  view.width = view.height = 4;
  view.camera.world_from_camera =
      glm::translate(glm::mat4(1.0f), {3, 1, 2}) *
      glm::rotate(glm::mat4(1.0f), 2.0f, glm::normalize(glm::vec3(-1, 1, 3)));
  const glm::vec3 p(view.view_from_world() * glm::vec4(0.25f, 0, 0, 1));
  const glm::vec3 n(view.view_from_world() * glm::vec4(0, 0, 1, 0));
  Image position(4, 4, 3), normal(4, 4, 3), albedo(4, 4, 3, 1.0f), mask(4, 4, 1, 1.0f);
  for (std::size_t i = 0; i < 48; ++i) {
    position.values()[i] = p[int(i % 3)];
    normal.values()[i] = n[int(i % 3)];
  }
  std::vector<double> seen[3];
  for (std::uint64_t seed = 0; seed < 32; ++seed) {
    const Reference reference =
        trace_reference(traced, turned, {}, view, {position, normal, normal, albedo, mask},
                        {.seed = seed, .d_max_world = 1.0f});
    for (int c = 0; c < 3; ++c) seen[c].push_back(double(reference.radiance.at(1, 2, c)));
  }
  const auto plain = trace_points(scene, probe_of(128, sky), {{{0.25, 0, 0}}},
                                  {.seed = 99, .d_max_world = 1.0f}, 32);
  // Texels of 128 columns, turned or not, are wrong by less than their second order.
  for (int c = 0; c < 3; ++c) {
    const Mean turned_mean = mean_of(seen[c]);
    const Mean plain_mean = channel(plain[0], c);
    EXPECT_TRUE(agrees({turned_mean.value - plain_mean.value,
                        std::hypot(turned_mean.standard_error, plain_mean.standard_error), 31.0},
                       0.0, 1e-3));
  }
}

TEST(TracedLight, PunctualLights) {
  const Scene scene = floor_and_wall();
  const Environment black = constant_environment(glm::vec3(0.0f));
  const glm::vec3 rho(0.5f, 1.0f, 0.25f);
  const Point point{{0.5, 0, 0}, {0, 0, 1}, rho};
  const auto lit = [&](const Light& light, float d_max) {
    const auto of = trace_points(scene, black, {point},
                                 {.rays_per_pixel = 16, .d_max_world = d_max}, 1, {light});
    return glm::dvec3(of[0].radiance[0][0], of[0].radiance[1][0], of[0].radiance[2][0]);
  };
  const auto expect = [&](glm::dvec3 found, double irradiance) {
    const glm::vec3 colour(2.0f, 1.0f, 0.5f);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(found[c], double(rho[c] * colour[c]) * irradiance / pi_d, 2e-6) << c;
    }
  };
  Light light{.name = "sun", .type = LightType::directional, .intensity = {2.0f, 1.0f, 0.5f}};
  light.direction_world = {-0.6f, 0, -0.8f};  // from the open side
  expect(lit(light, infinite), 0.8);
  light.direction_world = {0.6f, 0, -0.8f};  // from behind the wall, met after 0.5/0.6
  expect(lit(light, infinite), 0.0);
  expect(lit(light, 0.84f), 0.0);
  expect(lit(light, 0.82f), 0.8);
  light.direction_world = {0, 0, 1};  // from below
  expect(lit(light, infinite), 0.0);

  light.type = LightType::point;
  light.position_world = {0.5f, 0, 2};
  expect(lit(light, infinite), 1.0 / 4.0);
  light.position_world = {0.1f, 0, 0.3f};  // before the wall, which is beyond the light
  expect(lit(light, infinite), (0.3 / 0.5) / 0.25);
  light.position_world = {-0.1f, 0, 0.3f};
  expect(lit(light, infinite), 0.0);

  light.type = LightType::spot;
  light.position_world = {0.5f, 0, 2};
  light.direction_world = {0, 0, -1};
  expect(lit(light, infinite), 1.0 / 4.0);
  light.direction_world = {std::sin(0.5f), 0, -std::cos(0.5f)};
  light.inner_cone_angle = 0.3f;
  light.outer_cone_angle = 0.7f;
  const double ramp = (std::cos(0.5) - std::cos(0.7)) / (std::cos(0.3) - std::cos(0.7));
  expect(lit(light, infinite), ramp * ramp / 4.0);
  light.outer_cone_angle = 0.45f;
  expect(lit(light, infinite), 0.0);
}

TEST(TracedLight, PunctualLightThroughAPartialBlocker) {
  const Light light{.name = "sun",
                    .type = LightType::directional,
                    .direction_world = {0.6f, 0, -0.8f},
                    .intensity = glm::vec3(1.0f)};
  const auto of = trace_points(
      floor_and_wall(), constant_environment(glm::vec3(0.0f)), {{{0.5, 0, 0}}},
      {.rays_per_pixel = 16, .d_max_world = infinite, .weight = 1, .lambda_per_world = 2.0f}, 1,
      {light});
  const double d = 0.5 / 0.6;
  EXPECT_NEAR(of[0].radiance[0][0], 0.8 / pi_d * 2.0 * d / (1.0 + 2.0 * d), 2e-6);
}

TEST(TracedLight, ReportedVarianceIsThatOfTheMean) {
  const Scene scene = floor_and_wall();
  const Environment probe = load_environment({.source = "cathedral"});
  for (const Estimator estimator : all_estimators) {
    const auto of =
        trace_points(scene, probe, {{{0.25, 0, 0}}, {{0, 0.3, 0.25}, {1, 0, 0}}},
                     {.rays_per_pixel = 512, .estimator = estimator, .d_max_world = 1.0f}, 2048);
    for (const PointReplicates& point : of) {
      for (int c = 0; c < 3; ++c) {
        // The spread of the replicates' means, as a mean of squares so that it has an error itself.
        const double average = mean(point.radiance[c]);
        const double n = double(point.radiance[c].size());
        std::vector<double> difference;
        for (std::size_t i = 0; i < point.radiance[c].size(); ++i) {
          const double deviation = point.radiance[c][i] - average;
          difference.push_back(deviation * deviation * n / (n - 1) - point.reported_variance[c][i]);
        }
        EXPECT_TRUE(agrees(mean_of(difference), 0.0, 0.0)) << int(estimator) << " channel " << c;
        // The test could tell a variance that is wrong by this share.
        EXPECT_LT(8.0 * mean_of(difference).standard_error, 0.9 * mean(point.reported_variance[c]))
            << int(estimator) << " channel " << c;
      }
    }
  }
}

TEST(TracedLight, VarianceOfAPointDoesNotDependOnItsLane) {
  // The lanes of a tile are alike: the same point in two of them gets the same numbers.
  const auto of = trace_points(floor_and_wall(), load_environment({.source = "sky_sun"}),
                               {{{0.25, 0, 0}}, {{0.25, 0, 0}}}, {.d_max_world = 1.0f}, 8);
  EXPECT_EQ(of[0].radiance[1], of[1].radiance[1]);
  EXPECT_EQ(of[0].reported_variance[1], of[1].reported_variance[1]);
  EXPECT_NE(of[0].radiance[1][0], of[0].radiance[1][1]) << "tiles are independent";
}

TEST(TracedLight, ResultsDoNotDependOnTheNumberOfThreads) {
  const Environment probe = load_environment({.source = "sky_sun"});
  std::vector<std::vector<double>> results;
  for (const int threads : {1, 2, 5}) {
    set_thread_count(threads);
    results.push_back(trace_points(floor_and_wall(), probe, {{{0.25, 0, 0}}},
                                   {.rays_per_pixel = 256, .d_max_world = 1.0f}, 64)[0]
                          .radiance[0]);
  }
  set_thread_count(0);
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

TEST(TracedLight, SeedsCountAndOnlyPixelsWithASurface) {
  const Scene scene = floor_and_wall();
  const TracedScene traced(scene);
  View view;
  view.width = 7;  // the last tiles are cut off
  view.height = 5;
  Image position(7, 5, 3, 0.25f), normal(7, 5, 3), albedo(7, 5, 3, 1.0f), mask(7, 5, 1);
  mask.at(6, 4) = mask.at(2, 1) = 1.0f;
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 7; ++x) normal.at(x, y, 2) = 1.0f;
  }
  const auto trace = [&](std::uint64_t seed) {
    return trace_reference(traced, load_environment({.source = "sky_sun"}), {}, view,
                           {position, normal, normal, albedo, mask},
                           {.rays_per_pixel = 100, .seed = seed, .d_max_world = 1.0f});
  };
  const Reference first = trace(1), again = trace(1), other = trace(2), high = trace(1ULL << 32);
  EXPECT_EQ(first.radiance, again.radiance);
  EXPECT_NE(first.radiance, other.radiance);
  EXPECT_NE(first.radiance, high.radiance);
  // 100 rays are rounded up to 4 for each of 16 batches of both strategies.
  EXPECT_EQ(first.rays_per_pixel, 128);
  EXPECT_EQ(first.rays, 2u * 128u);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 7; ++x) {
      const bool surface = mask.at(x, y) > 0.0f;
      EXPECT_EQ(first.radiance.at(x, y) > 0.0f, surface);
      EXPECT_EQ(first.ambient_occlusion.at(x, y) > 0.0f, surface);
      EXPECT_EQ(first.radiance_variance.at(x, y) > 0.0f, surface);
    }
  }
}

}  // namespace
}  // namespace occlab::test
