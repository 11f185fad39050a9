// What the march may see: how far it reaches, what is off the screen or out of reach, and the two
// small distances that keep a surface from occluding itself.

#include <gtest/gtest.h>

#include "renderers/methods/sample_set.h"
#include "renderers/shared/frame.h"
#include "tests/gpu/gpu_frame.h"

namespace occlab::test {
namespace {

TEST(Reach, EndsAtDMaxAndNotBefore) {
  // With many steps a wall is found from all points nearer than d_max, and from none beyond. Many
  // rows, for the last 3% before d_max.
  const TestFrame frame(floor_and_tall_wall(), look_at({8, 3.2f, 0}, {0, 1.0f, 0}, 0.35f, 160, 600),
                        constant_environment(glm::vec3(1.0f)));
  const Image k = frame.layer("ssao", "ambient_occlusion",
                              {{"samples", 64L},
                               {"steps", 64L},
                               {"filter", "none"},
                               {"bias_world", 1e-4},
                               {"epsilon_world", 1e-4}});
  const float pixel = 0.02f;  // a pixel of the floor, across
  int within = 0, found = 0, beyond = 0;
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 40; x < 120; ++x) {
      const glm::vec3 p(frame.frame().view.camera.world_from_camera *
                        glm::vec4(glm::vec3(pixel3(frame.surface().position_view, x, y)), 1.0f));
      if (p.y > 1e-4f) continue;
      if (p.x > 0.97f && p.x < 0.99f) {
        ++within;
        found += k.at(x, y) < 1.0f - 1e-6f ? 1 : 0;
      } else if (p.x > 1.0f + pixel) {
        ++beyond;
        EXPECT_NEAR(k.at(x, y), 1.0f, 1e-5f) << p.x;
      }
    }
  }
  EXPECT_GT(within, 50);
  EXPECT_GT(beyond, 500);
  EXPECT_GT(found, within / 10);
}

TEST(Reach, WhatIsOffTheScreenIsVisible) {
  // The same floor seen so closely that the wall is outside of the image.
  const View close = look_at({1.2f, 1.5f, 0}, {1.0f, 0, 0}, 0.4f, 32, 20);
  const TestFrame frame(floor_and_tall_wall(), close, constant_environment(glm::vec3(1.0f)));
  const Image k = frame.layer("ssao", "ambient_occlusion", {{"d_max_world", 5.0}});
  for (const float value : k.values()) EXPECT_NEAR(value, 1.0f, 1e-5f);

  // And it is counted: the share of sample points that project outside, computed here.
  const long samples = 12, steps = 3, seed = 4;
  const Image share =
      frame.layer("ssao", "off_screen",
                  {{"d_max_world", 0.4}, {"samples", samples}, {"steps", steps}, {"seed", seed}});
  const SampleSet set = make_sample_set(int(samples), std::uint64_t(seed));
  double counted = 0.0;
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 32; ++x) {
      const glm::vec3 p(pixel3(frame.surface().position_view, x, y));
      const glm::vec4 turn = set.sets[std::size_t(x & 3) + 4 * std::size_t(y & 3)];
      const glm::mat3 tangent = tangent_frame(glm::vec3(pixel3(frame.surface().normal_view, x, y)));
      int outside = 0;
      for (const glm::vec4& s : set.directions) {
        const glm::vec3 turned(turn.x * s.x - turn.y * s.y, turn.y * s.x + turn.x * s.y, s.z);
        for (long step = 0; step < steps; ++step) {
          const float xi = glm::fract(s.w + turn.z);
          const glm::vec3 q = p + tangent * turned * (0.4f * (float(step) + xi) / float(steps));
          const float focal = close.focal_pixels() / -q.z;
          outside += q.z >= 0 || std::abs(focal * q.x) > 16 || std::abs(focal * q.y) > 10 ? 1 : 0;
        }
      }
      // One point may lie on the border.
      EXPECT_NEAR(share.at(x, y), float(outside) / float(samples * steps), 1.01f / 36.0f);
      counted += outside;
    }
  }
  EXPECT_GT(counted, 500.0);
  EXPECT_LT(counted, 0.9 * 32 * 20 * 36);
}

TEST(Reach, AForegroundBeyondTheReachDoesNotOcclude) {
  // A bar near the camera hides what samples of the floor behind it project onto; it is nearer than
  // they are, and farther from their points than d_max.
  const Scene scene = SceneBuilder()
                          .add(quad({-9, 0, -9}, {0, 0, 18}, {18, 0, 0}))
                          .add(quad({-3, 2.0f, 2.2f}, {6, 0, 0}, {0, 0.3f, 0}))
                          .build();
  const TestFrame frame(scene, look_at({0, 4, 5}, {0, 0, 0}, 0.5f, 48, 36),
                        constant_environment(glm::vec3(1.0f)));
  const Image near = frame.layer("ssao", "ambient_occlusion", {{"filter", "none"}});
  const Image far =
      frame.layer("ssao", "ambient_occlusion", {{"filter", "none"}, {"d_max_world", 5.0}});
  int floors = 0, bar = 0, darkened = 0;
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) {
      const glm::vec3 p(frame.frame().view.camera.world_from_camera *
                        glm::vec4(glm::vec3(pixel3(frame.surface().position_view, x, y)), 1.0f));
      EXPECT_NEAR(near.at(x, y), 1.0f, 1e-5f) << x << " " << y;
      (p.y < 1e-3f ? floors : bar) += 1;
      darkened += far.at(x, y) < 0.99f ? 1 : 0;
    }
  }
  EXPECT_GT(floors, 500);
  EXPECT_GT(bar, 50);
  EXPECT_GT(darkened, 100) << "within reach it does";
}

TEST(Reach, BiasAndEpsilonLetNearBlockersThrough) {
  const TestFrame frame(floor_and_tall_wall(), look_at({4, 3, 2}, {0.5f, 0.3f, 0}, 0.5f, 48, 36),
                        constant_environment(glm::vec3(1.0f)));
  const auto mean_occlusion = [&](const char* name, double value) {
    Values values = {{"filter", "none"}, {"samples", 16L}};
    values.emplace_back(name, value);
    const Image k = frame.layer("ssao", "ambient_occlusion", values);
    double sum = 0.0;
    for (const float v : k.values()) sum += double(v);
    return sum / double(k.pixel_count());
  };
  for (const char* name : {"bias_world", "epsilon_world"}) {
    EXPECT_LT(mean_occlusion(name, 1e-4) + 1e-3, mean_occlusion(name, 0.3)) << name;
    EXPECT_EQ(mean_occlusion(name, 100.0), 1.0) << name << " beyond everything";
  }
}

}  // namespace
}  // namespace occlab::test
