// The passes in the scenes that carry their expected values.

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "harness/verify/analytic_bench.h"
#include "harness/verify/analytic_checks.h"
#include "renderers/shared/sh.h"

namespace occlab {
namespace {

TEST(Passes, ScenesThatCarryTheirExpectedValues) {
  const Checks checks =
      verify_passes({.cases = {}, .output = testing::TempDir() + "occlab-passes"});
  EXPECT_GE(checks.size(), 190u);
  for (const Check& check : checks) {
    EXPECT_TRUE(check.passes) << check.name << ", " << check.quantity << ": " << check.measured
                              << ", expected " << check.expected << ", accepted " << check.bound
                              << "; " << check.detail;
  }
}

TEST(Harmonics, InWorldSpaceAreTheSameFunction) {
  const glm::mat3 view_from_world(
      glm::rotate(glm::mat4(1.0f), 1.1f, glm::normalize(glm::vec3(1, 2, -1))));
  Image view(1, 1, 16);
  for (int i = 0; i < 16; ++i) view.at(0, 0, i) = std::sin(1.7f * float(i) + 0.3f);
  const Image world = sh_in_world(view, view_from_world);
  const auto value = [](const Image& c, glm::vec3 d) {
    const Sh4 y = sh_basis(d);
    const glm::vec4 quarters[4] = {y.c0, y.c1, y.c2, y.c3};
    float sum = 0.0f;
    for (int i = 0; i < 16; ++i) sum += c.at(0, 0, i) * quarters[i / 4][i % 4];
    return sum;
  };
  for (const glm::vec3& d : {glm::vec3(0, 0, 1), glm::vec3(0.6f, 0.8f, 0),
                             glm::vec3(0, -0.6f, 0.8f), glm::normalize(glm::vec3(-1, 2, -3))}) {
    EXPECT_NEAR(value(world, d), value(view, view_from_world * d), 1e-5f);
  }
}

}  // namespace
}  // namespace occlab
