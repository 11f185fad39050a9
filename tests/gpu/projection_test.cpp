// S3HO's two ways from visible directions to SH: their bits at once in the tangent frame, and the
// basis functions of each direction in view space. The same coefficients within their halves.

#include <gtest/gtest.h>

#include "harness/workbench.h"
#include "renderers/methods/cpu_passes.h"
#include "tests/gpu/gpu_frame.h"

namespace occlab::test {
namespace {

/// Each way rounds to a half once, and its sums of N floats.
void expect_equal(const Image& bits, const Image& direct, long samples, const std::string& what) {
  double largest = 0.0;
  for (std::size_t i = 0; i < bits.values().size(); ++i) {
    const float c = direct.values()[i];
    const float bound = 2.0f * 0x1p-11f * std::abs(c) + 0x1p-14f + 0x1p-23f * float(samples + 64);
    EXPECT_NEAR(bits.values()[i], c, bound) << what << ", value " << i;
    largest = std::max(largest, double(std::abs(c)));
  }
  EXPECT_GT(largest, 0.1) << what;
}

Image coefficients(const Frame& frame, const Values& values, const char* projection,
                   const char* path) {
  const MethodInfo& info = find_method("s3ho");
  ParameterSet parameters(info.parameters);
  for (const auto& [name, value] : values) parameters.set(name, value);
  parameters.set("projection", projection);
  Metadata facts;
  const Image image = info.make()->evaluate(frame, parameters, facts).at("sh_visibility");
  EXPECT_EQ(facts.at("projection"), path);
  return image;
}

void expect_ways_agree(const Frame& frame, long samples, long steps, double d_max,
                       const std::string& what) {
  const Values values = {{"samples", samples},
                         {"steps", steps},
                         {"seed", samples + 3},
                         {"d_max_world", d_max},
                         {"filter", "none"}};
  expect_equal(coefficients(frame, values, "auto", "visibility bits"),
               coefficients(frame, values, "direct", "direct"), samples,
               what + ", N = " + std::to_string(samples));
}

/// A ball seen from near by: normals of every direction that a camera sees.
TEST(Projection, IsTheSameForEveryNormal) {
  const TestFrame frame(SceneBuilder()
                            .add(sphere_part({0, 0, 0}, 1, 0, pi_d, 48))
                            .add(quad({-3, -0.8f, -3}, {0, 0, 6}, {6, 0, 0}))
                            .build(),
                        look_at({0.3f, 0.9f, 2.1f}, {0, 0, 0}, 1.3f, 64, 48),
                        constant_environment(glm::vec3(1.0f)));
  // Whole rings, rings cut short, no rings, more than one word of bits, constants and buffers.
  for (const long samples : {1L, 5L, 8L, 16L, 17L, 31L, 32L, 33L, 64L, 100L}) {
    expect_ways_agree(frame.frame(), samples, 2, 1.0, "ball");
  }
  expect_ways_agree(frame.frame(), 32, 9, 1.0, "ball, many steps");
}

/// Surfaces whose normals are the axes of view space, where the rotation's angles degenerate.
TEST(Projection, IsTheSameAtThePoles) {
  const TestFrame frame(SceneBuilder()
                            .add(quad({-2, 0, -2}, {0, 0, 4}, {4, 0, 0}))
                            .add(quad({-1, 0, -2}, {0, 3, 0}, {0, 0, 4}))
                            .add(quad({-2, 0, -1}, {4, 0, 0}, {0, 3, 0}))
                            .build(),
                        look_at({0.6f, 0.8f, 4}, {0.6f, 0.8f, 0}, 0.9f, 50, 38),
                        constant_environment(glm::vec3(1.0f)));
  for (const long samples : {8L, 16L, 32L}) {
    expect_ways_agree(frame.frame(), samples, 3, 2.0, "axes");
  }
}

TEST(Projection, OfWeightedVisibilityIsDirect) {
  const TestFrame frame(floor_and_tall_wall(), look_at({4, 3, 0}, {0, 0.5f, 0}, 0.6f, 24, 16),
                        constant_environment(glm::vec3(1.0f)));
  for (const char* weight : {"lambda", "smoothstep"}) {
    coefficients(frame.frame(), {{"weight", weight}}, "auto", "direct");
  }
}

// The last one: a workbench has a context of its own.
TEST(Projection, IsTheSameInEveryScene) {
  for (const char* scene : {"gallery", "three_boxes"}) {
    Workbench bench({.scene = scene,
                     .view = "",
                     .width = 96,
                     .height = 54,
                     .probe = ProbeSettings{.source = "sky_sun"}},
                    "surfaceless");
    expect_ways_agree(bench.frame(), 32, 2, 0.5, scene);
  }
}

}  // namespace
}  // namespace occlab::test
