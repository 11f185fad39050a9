// What the representations are of one another, and of the ray-traced reference.
//
// The first half is exact but for rounding, per pixel. The second compares means over replicates
// with seeds of their own by Student's t-test; each test case, with all its regions, raises a false
// alarm with probability 1e-6 (Sidak). The seeds are fixed: a case that passes goes on passing.

#include <gtest/gtest.h>

#include "harness/verify/reference_identities.h"
#include "harness/verify/representation_identities.h"
#include "tests/gpu/gpu_frame.h"

namespace occlab::test {
namespace {

constexpr double family_level = 1e-6;

/// A floor, a wall and a ball.
Scene still_life() {
  return SceneBuilder()
      .add(quad({-4, 0, -4}, {0, 0, 8}, {8, 0, 0}))
      .material({0.8f, 0.5f, 0.3f})
      .add(quad({-1, 0, -4}, {0, 3, 0}, {0, 0, 8}))
      .add(sphere_part({0.4, 0.5, 0.2}, 0.5, 0, pi_d, 24))
      .build();
}

const View small_view = look_at({4, 3, 3}, {0.2f, 0.5f, 0.2f}, 0.5f, 40, 32);

Environment sun_and_sky() {
  return probe_of(64, [](glm::vec3 d) {
    const bool sun = glm::dot(d, glm::normalize(glm::vec3(0.5f, 0.7f, 0.3f))) > 0.995f;
    return sun ? glm::vec3(300, 270, 200) : glm::vec3(1.0f + d.x, 1.2f + d.y * d.z, 1.5f - d.z);
  });
}

std::vector<Light> lights() {
  return {{.name = "sun",
           .type = LightType::directional,
           .direction_world = glm::normalize(glm::vec3(-1, -2, -0.5f)),
           .intensity = {3, 2, 1}},
          {.name = "lamp", .position_world = {0.9f, 1.3f, 0.3f}, .intensity = {0.5f, 1, 2}}};
}

ParameterSet parameters_of(const Values& values) {
  ParameterSet parameters(find_method("s3ho").parameters);
  for (const auto& [name, value] : values) parameters.set(name, value);
  return parameters;
}

TEST(Identity, HoldsPerPixel) {
  const TestFrame frame(still_life(), small_view, sun_and_sky(), lights());
  for (const char* source : {"depth", "traced"}) {
    for (const char* weight : {"binary", "lambda", "smoothstep"}) {
      for (const long samples : {1L, 9L, 64L}) {
        const LayerAgreement agreement =
            representation_identities(frame.frame(), parameters_of({{"visibility", source},
                                                                    {"weight", weight},
                                                                    {"samples", samples},
                                                                    {"seed", samples},
                                                                    {"hanning_width", 2.5}}));
        EXPECT_EQ(agreement.expected.all().size(), 5u);
        const WorstPixel worst = worst_pixel(agreement);
        EXPECT_LE(worst.share, 1.0)
            << source << " " << weight << " " << samples << " samples: " << describe(worst);
      }
    }
  }
}

TEST(Identity, FailsForOtherSamplesOrAnotherVisibility) {
  const TestFrame frame(still_life(), small_view, sun_and_sky(), lights());
  const LayerAgreement plain =
      representation_identities(frame.frame(), parameters_of({{"visibility", "traced"}}));
  for (const Values& values :
       {Values{{"visibility", "traced"}, {"seed", 1L}}, Values{{"visibility", "depth"}},
        Values{{"visibility", "traced"}, {"d_max_world", 1.1}}}) {
    LayerAgreement other = representation_identities(frame.frame(), parameters_of(values));
    for (const Layers::Layer& layer : plain.measured.all()) {
      LayerAgreement mixed;
      mixed.measured.add(layer.name, layer.image);
      mixed.expected.add(layer.name, other.expected.at(layer.name));
      mixed.bounds.add(layer.name, other.bounds.at(layer.name));
      EXPECT_GT(worst_pixel(mixed).share, 1.0) << layer.name;
    }
  }
}

TEST(Identity, BentConeOfAnOpenPlaneGivesAllOfAConstantProbe) {
  // With the exact angle E = pi AO L (1 + cos C)(N.n) = pi AO L 2 (N_ss.n), and stratified heights
  // have a mean of exactly 1/2. Levels are mixed by the cosine, in which L_c is linear.
  const float L = 2.0f;
  const TestFrame frame(open_floor(), small_view, constant_environment(glm::vec3(L)));
  const Layers layers = frame.evaluate(
      "ssbn", {{"cone_angle", "exact"}, {"filter", "none"}, {"visibility", "traced"}});
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) {
      if (frame.surface().mask.at(x, y) < 0.5f) continue;
      EXPECT_EQ(layers.at("uniform_occlusion").at(x, y), 1.0f);
      EXPECT_NEAR(layers.at("radiance").at(x, y), double(L), 2e-6 * double(L));
    }
  }
}

void expect_equal(const ReferenceComparison& comparison, const std::string& layer, int replicates) {
  const double critical =
      critical_standard_errors(family_level, int(comparison.regions.size()), replicates);
  const RegionMeans& worst = worst_region(comparison, layer);
  EXPECT_LE(std::abs(worst.measured - worst.expected), critical * worst.standard_error)
      << layer << "[" << worst.channel << "] of " << worst.region << ": " << worst.measured
      << " for " << worst.expected << ", standard error " << worst.standard_error;
}

void expect_different(const ReferenceComparison& comparison, const std::string& layer,
                      int replicates) {
  const double critical =
      critical_standard_errors(family_level, int(comparison.regions.size()), replicates);
  const RegionMeans& worst = worst_region(comparison, layer);
  EXPECT_GT(std::abs(worst.measured - worst.expected), critical * worst.standard_error) << layer;
}

const Replication replication{
    .replicates = 16, .directions = 128, .rays_per_pixel = 512, .seed = 1};

TEST(Reference, IsWhatConvergesWithTracedVisibility) {
  const TestFrame frame(still_life(), small_view, order4_environment(sun_and_sky(), 256));
  for (const char* weight : {"binary", "smoothstep"}) {
    const ReferenceComparison comparison =
        compare_to_reference(frame.frame(), parameters_of({{"weight", weight}}), replication);
    EXPECT_GT(comparison.regions.size(), 100u);
    for (const char* layer : {"ssao_ambient_occlusion", "s3ho_radiance", "ssdo_radiance"}) {
      expect_equal(comparison, layer, replication.replicates);
    }
  }
}

TEST(Reference, IsS3hoUnderAnOrder4ProbeOnly) {
  // Under the sun itself SSAO's k_A and SSDO still are the reference; S3HO has lost what its four
  // bands do not hold.
  const TestFrame frame(still_life(), small_view, sun_and_sky());
  const ReferenceComparison comparison =
      compare_to_reference(frame.frame(), parameters_of({}), replication);
  expect_equal(comparison, "ssao_ambient_occlusion", replication.replicates);
  expect_equal(comparison, "ssdo_radiance", replication.replicates);
  expect_different(comparison, "s3ho_radiance", replication.replicates);
}

TEST(Reference, DiffersByAPercentOfOcclusion) {
  // What the comparison can see: the same means with the measured side 1% higher.
  const TestFrame frame(still_life(), small_view, order4_environment(sun_and_sky(), 256));
  ReferenceComparison comparison =
      compare_to_reference(frame.frame(), parameters_of({}), replication);
  for (RegionMeans& region : comparison.regions) region.measured *= 1.01;
  for (const char* layer : {"ssao_ambient_occlusion", "s3ho_radiance", "ssdo_radiance"}) {
    expect_different(comparison, layer, replication.replicates);
  }
}

TEST(Reference, Order4EnvironmentIsItsOwnReconstruction) {
  const Environment light = order4_environment(sun_and_sky(), 256);
  const ShRgb sh = project_sh(light, glm::mat3(1.0f));
  float lowest = 1.0f;
  for (int y = 0; y < light.texels.height(); ++y) {
    for (int x = 0; x < light.texels.width(); ++x) {
      const glm::vec2 uv((float(x) + 0.5f) / 256.0f, (float(y) + 0.5f) / 128.0f);
      const glm::vec3 again = sh_dot_rgb(sh, sh_basis(equirect_direction(uv)));
      for (int c = 0; c < 3; ++c) {
        const float texel = light.texels.at(x, y, c);
        EXPECT_NEAR(again[c], texel, 2e-3f * (1.0f + texel));
        lowest = std::min(lowest, texel);
      }
    }
  }
  EXPECT_EQ(lowest, 0.0f);
}

}  // namespace
}  // namespace occlab::test
