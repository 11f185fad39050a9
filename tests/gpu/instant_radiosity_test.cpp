// Instant radiosity: virtual point lights against closed forms and against traced bounces, and what
// screen space adds near by.

#include <gtest/gtest.h>

#include <algorithm>

#include "renderers/methods/fact_warnings.h"
#include "tests/gpu/gpu_frame.h"

namespace occlab::test {
namespace {

const Environment black = constant_environment(glm::vec3(0.0f));

Light lamp_at(glm::vec3 position, glm::vec3 intensity) {
  return {.name = "lamp", .position_world = position, .intensity = intensity};
}

/// Inside of a sphere about the origin, a lamp at its centre.
struct LitSphere {
  static constexpr double radius = 2.0;
  static constexpr double rho = 0.6;
  static constexpr double intensity = 5.0;
  /// Of one bounce, the same everywhere: E_0 = I/R^2 makes each patch send rho E_0/pi, and with the
  /// kernel cos cos/(pi d^2) = 1/(4 pi R^2) they add up to E_1 = rho E_0.
  static constexpr double indirect_irradiance = rho * intensity / (radius * radius);

  explicit LitSphere(int rings = 40)
      : frame(SceneBuilder()
                  .add(sphere_part({0, 0, 0}, radius, 0, pi_d, rings))
                  .material(glm::vec3(float(rho)))
                  .build(),
              look_at({0.3f, 0.2f, 0.1f}, {1, 0.5f, 2}, 1.4f, 64, 48), black,
              {lamp_at({0, 0, 0}, glm::vec3(float(intensity)))}) {}

  /// The mean of E_1 as a share of the closed form's.
  double share(const Values& values) const {
    Values all = {{"environment_lights", 0L},
                  {"correction_samples", 0L},
                  {"filter", "none"},
                  {"most_slope", 200.0}};
    all.insert(all.end(), values.begin(), values.end());
    const Image radiance = frame.layer("instant_radiosity", "radiance_indirect", all);
    double sum = 0.0;
    int count = 0;
    for (int y = 16; y < 32; ++y) {
      for (int x = 20; x < 44; ++x) {
        sum += double(radiance.at(x, y)) * pi_d / rho;
        ++count;
      }
    }
    return sum / count / indirect_irradiance;
  }

  TestFrame frame;
};

TEST(InstantRadiosity, OfALitSphereIsTheClosedForm) {
  // The kernel is constant: as long as nothing is clamped, every set of virtual lights gives the
  // same.
  const LitSphere sphere;
  for (const long seed : {0L, 1L}) {
    const double share =
        sphere.share({{"seed", seed}, {"bounce_lights", 32L}, {"bounce_clamp_world", 1e-3}});
    EXPECT_NEAR(share, 1.0, 0.02) << seed;
  }
}

TEST(InstantRadiosity, ClampAndBounceNearbyAreTheWhole) {
  // Squared distances are uniform in [0, 4R^2]: with q = c^2/(4R^2) the clamp leaves 1 - q/2, and
  // what is near by has the other q/2.
  const LitSphere sphere;
  const auto q_of = [](double clamp) {
    return clamp * clamp / (4.0 * LitSphere::radius * LitSphere::radius);
  };
  for (const double clamp : {1.6, 2.4}) {
    // A pixel's lights within the clamp are few, but pixels in all directions are averaged.
    const double share = sphere.share({{"bounce_lights", 64L}, {"bounce_clamp_world", clamp}});
    EXPECT_NEAR(share, 1.0 - 0.5 * q_of(clamp), 0.02) << clamp;
  }
  // As far as the senders are on the screen. They are near the horizon: facets must be
  // small, and the distance many pixels.
  const LitSphere fine(160);
  for (const double clamp : {0.8, 1.0}) {
    const double share = fine.share({{"bounce_lights", 0L},
                                     {"bounce_clamp_world", clamp},
                                     {"near_bounce", "screen"},
                                     {"samples", 256L},
                                     {"steps", 32L}});
    EXPECT_NEAR(share, 0.5 * q_of(clamp), 0.1 * 0.5 * q_of(clamp)) << clamp;
  }
}

/// A white floor beside a red wall, a block on it.
Scene corner() {
  return SceneBuilder()
      .add(quad({0, 0, -3}, {0, 0, 6}, {4, 0, 0}))
      .material({0.7f, 0.7f, 0.7f})
      .add(quad({0, 0, -3}, {0, 3, 0}, {0, 0, 6}))
      .material({0.8f, 0.2f, 0.1f})
      .add(quad({1.2f, 0.5f, -0.4f}, {0, 0, 0.8f}, {0.8f, 0, 0}))
      .material({0.5f, 0.5f, 0.5f})
      .build();
}

TEST(InstantRadiosity, AgreesWithTracedBounces) {
  // The mean light of each third of the floor, over 12 seeds of 128 virtual lights. With 11 degrees
  // of freedom and 9 tests, 6 standard errors are exceeded by chance with a probability below 1e-3;
  // 2% are for the maps' resolution.
  const TestFrame frame(corner(), look_at({4, 3.5f, 2.5f}, {1, 0, 0}, 0.7f, 48, 36), black,
                        {lamp_at({1.5f, 2, 0.5f}, {4, 4, 4})});
  const auto region_means = [&](const Image& radiance) {
    std::array<glm::dvec3, 3> sums{};
    std::array<int, 3> counts{};
    for (int y = 0; y < frame.height(); ++y) {
      for (int x = 0; x < frame.width(); ++x) {
        if (frame.surface().mask.at(x, y) == 0.0f) continue;
        const glm::vec3 p(frame.frame().view.camera.world_from_camera *
                          glm::vec4(glm::vec3(pixel3(frame.surface().position_view, x, y)), 1.0f));
        if (std::abs(p.y) > 1e-4f || p.x < 0.3f || std::abs(p.z) > 2.0f) continue;
        const auto region = std::size_t(p.x < 1.0f ? 0 : p.x < 2.0f ? 1 : 2);
        sums[region] += pixel3(radiance, x, y);
        ++counts[region];
      }
    }
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_GT(counts[i], 30);
      sums[i] /= counts[i];
    }
    return sums;
  };
  const auto truth = region_means(
      frame.layer("rtgi_shaded", "radiance_indirect",
                  {{"rays_per_pixel", 512L}, {"d_max_world", 1e4}, {"estimator", "cosine"}}));
  constexpr int seeds = 12;
  std::array<glm::dvec3, 3> sum{}, squares{};
  for (int seed = 0; seed < seeds; ++seed) {
    const auto means = region_means(frame.layer("instant_radiosity", "radiance_indirect",
                                                {{"seed", long(seed)},
                                                 {"environment_lights", 0L},
                                                 {"bounce_lights", 128L},
                                                 {"shadow_map_side", 128L},
                                                 {"bounce_clamp_world", 0.05}}));
    for (std::size_t i = 0; i < 3; ++i) {
      sum[i] += means[i];
      squares[i] += means[i] * means[i];
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    for (int c = 0; c < 3; ++c) {
      const double mean = sum[i][c] / seeds;
      const double error = std::sqrt((squares[i][c] / seeds - mean * mean) / (seeds - 1));
      EXPECT_NEAR(mean, truth[i][c], 6.0 * error + 0.02 * truth[i][c]) << i << " " << c;
      EXPECT_LT(error, 0.05 * truth[i][c]) << i << " " << c;
    }
  }
  EXPECT_GT(truth[0].x, 2.0 * truth[0].z);  // red, from the wall
}

TEST(InstantRadiosity, WithoutVirtualLightsIsShadowMaps) {
  const TestFrame frame(corner(), look_at({4, 3.5f, 2.5f}, {1, 0, 0}, 0.7f, 32, 24),
                        constant_environment(glm::vec3(1.0f)),
                        {lamp_at({1.5f, 2, 0.5f}, {4, 4, 4})});
  const Values values = {{"environment_lights", 16L}, {"shadow_map_side", 64L}};
  Values without = values;
  without.emplace_back("bounce_lights", 0L);
  const Image direct = frame.layer("shadow_maps", "radiance", values);
  const Image all = frame.layer("instant_radiosity", "radiance", without);
  for (std::size_t i = 0; i < all.values().size(); ++i) {
    EXPECT_EQ(all.values()[i], direct.values()[i]) << i;
  }
  // An environment alone has no reflective shadow map.
  const TestFrame unlit(corner(), look_at({4, 3.5f, 2.5f}, {1, 0, 0}, 0.7f, 16, 16),
                        constant_environment(glm::vec3(1.0f)));
  Metadata facts;
  unlit.evaluate("instant_radiosity", {{"environment_lights", 4L}}, &facts);
  EXPECT_EQ(facts.at("virtual_lights"), "0");
  ParameterSet parameters(find_method("instant_radiosity").parameters);
  ASSERT_EQ(fact_warnings(parameters, facts).size(), 1u);
  EXPECT_NE(fact_warnings(parameters, facts).front().find("does not bounce"), std::string::npos);
  parameters.set("bounce_lights", 0L);
  EXPECT_TRUE(fact_warnings(parameters, facts).empty()) << "none were asked for";
}

TEST(InstantRadiosity, PartsAddUpBeforeAndAfterTheFilter) {
  const TestFrame frame(corner(), look_at({4, 3.5f, 2.5f}, {1, 0, 0}, 0.7f, 48, 36), black,
                        {lamp_at({1.5f, 2, 0.5f}, {4, 4, 4})});
  const Layers layers = frame.evaluate("instant_radiosity", {{"environment_lights", 0L},
                                                             {"bounce_lights", 8L},
                                                             {"shadow_map_side", 64L},
                                                             {"bounce_clamp_world", 0.5},
                                                             {"near_bounce", "screen"}});
  const Image& albedo = frame.surface().albedo;
  double nearby = 0.0, filtered = 0.0;
  for (std::size_t i = 0; i < albedo.values().size(); ++i) {
    const float direct = albedo.values()[i] / pi * layers.at("irradiance").values()[i];
    EXPECT_NEAR(layers.at("radiance").values()[i],
                direct + layers.at("radiance_indirect").values()[i], 1e-5f);
    EXPECT_NEAR(layers.at("radiance_unfiltered").values()[i],
                direct + layers.at("radiance_indirect_unfiltered").values()[i], 1e-5f);
    nearby += double(layers.at("radiance_indirect_unfiltered").values()[i]);
    filtered += double(layers.at("radiance_indirect").values()[i]);
  }
  EXPECT_NEAR(filtered / nearby, 1.0, 0.05);  // and is moved, not made
  EXPECT_NE(filtered, nearby);
}

}  // namespace
}  // namespace occlab::test
