// The ray tracer's ambient occlusion: the scenes that carry their expected values, and what no
// scene file can say.

#include <gtest/gtest.h>

#include "harness/verify/analytic_checks.h"
#include "tests/analytic/built_scenes.h"
#include "tests/analytic/traced_points.h"

namespace occlab::test {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

/// The plane x = 0 from z = 0 up, facing +X.
Mesh wall(float half_width, float height) {
  return quad({0, -half_width, 0}, {0, 2 * half_width, 0}, {0, 0, height});
}

TEST(Rays, ScenesThatCarryTheirExpectedValues) {
  const Checks checks =
      verify_reference({.cases = {}, .output = testing::TempDir() + "occlab-rays"});
  EXPECT_GE(checks.size(), 70u);
  for (const Check& check : checks) {
    EXPECT_TRUE(check.passes) << check.name << ", " << check.quantity << ": " << check.measured
                              << ", expected " << check.expected << ", accepted " << check.bound
                              << "; " << check.detail;
  }
}

TEST(Rays, SmoothstepEdges) {
  // Where the fade starts at d_max, or d_max is infinite, there is no fade left: every blocker
  // blocks. Both are accepted values.
  const Scene scene = SceneBuilder().add(wall(1.5f, 1.5f)).build();
  const double kappa = 0.25;
  TraceSettings settings{.d_max_world = 1.0f, .weight = 2, .fade_start = 1.0f};
  EXPECT_TRUE(agrees(trace_occlusion(scene, {{{kappa, 0, 0}}}, settings)[0], 0.657481));
  settings.d_max_world = infinite;
  for (const float start : {0.0f, 0.75f, 1.0f}) {
    TraceSettings faded = settings;
    faded.fade_start = start;
    TraceSettings binary = settings;
    binary.weight = 0;
    const double expected = trace_occlusion(scene, {{{kappa, 0, 0}}}, binary)[0].value;
    EXPECT_EQ(trace_occlusion(scene, {{{kappa, 0, 0}}}, faded)[0].value, expected) << start;
  }
}

TEST(Rays, InstancesBlockLikeGeometry) {
  // A mesh that is used twice is instanced, one that is used once is not.
  const Mesh unit = quad({0, -1, 0}, {0, 2, 0}, {0, 0, 1});
  glm::mat4 first(1.0f), second(1.0f);
  first[1][1] = first[2][2] = 1.5f;     // a wall of 1.5 units, half its width each way
  second[3] = glm::vec4(0, 0, -50, 1);  // out of the way
  const Scene once = SceneBuilder().add(unit, first).build();
  const Scene twice = SceneBuilder().add(unit, first).instance(0, second).build();
  const TraceSettings settings{.rays_per_pixel = 4096, .d_max_world = 1.0f};
  EXPECT_TRUE(agrees(trace_occlusion(once, {{{0.25, 0, 0}}}, settings)[0], 0.657481));
  EXPECT_TRUE(agrees(trace_occlusion(twice, {{{0.25, 0, 0}}}, settings)[0], 0.657481));
}

}  // namespace
}  // namespace occlab::test
