// Depth peeling and additional cameras [SSDO sec. 4]: what the layers and cameras show, scenes in
// which they give the right answer and the first surfaces alone do not, and what is said of meshes
// and cameras that are not as they should be.

#include "renderers/gl/hidden_surfaces.h"

#include <gtest/gtest.h>

#include <numeric>

#include "renderers/methods/fact_warnings.h"
#include "renderers/methods/hidden_facts.h"
#include "tests/gpu/gpu_frame.h"

namespace occlab::test {
namespace {

constexpr glm::vec3 slab_low(-0.6f, 0.5f, -0.5f);
constexpr glm::vec3 slab_high(0.6f, 0.62f, 0.5f);

/// A slab floating above a floor, both closed.
Scene floating_slab() {
  SceneBuilder scene;
  scene.add_box({-3, -0.3f, -3}, {3, 0, 3});
  scene.add_box(slab_low, slab_high);
  return scene.build();
}

const View over_the_slab = look_at({0.3f, 2.2f, 4.0f}, {0, 0.3f, 0}, 0.6f, 96, 72);

Light sun_toward(glm::vec3 direction) {
  return {.name = "sun",
          .type = LightType::directional,
          .direction_world = -direction,
          .intensity = glm::vec3(pi)};
}

std::vector<std::string> warnings(const Metadata& facts) {
  return fact_warnings(ParameterSet({}), facts);
}

Environment darkness() { return constant_environment(glm::vec3(0.0f)); }

HiddenSettings layers_of(int count) {
  return {.kind = HiddenKind::layers, .count = count, .complete = true};
}

glm::vec3 world_position(const TestFrame& frame, const Image& position_view, int x, int y) {
  return glm::vec3(frame.frame().view.camera.world_from_camera *
                   glm::vec4(glm::vec3(pixel3(position_view, x, y)), 1.0f));
}

TEST(Layers, AreFrontsAndBacksInTheOrderOfDepth) {
  const TestFrame test(floating_slab(), over_the_slab, constant_environment(glm::vec3(1)));
  const HiddenImages& hidden = test.frame().hidden_images(layers_of(4));
  ASSERT_EQ(hidden.images.size(), 4u);
  const glm::mat3 rotation = over_the_slab.world_from_view_rotation();
  int four = 0, two = 0;
  for (int y = 0; y < test.height(); ++y) {
    for (int x = 0; x < test.width(); ++x) {
      float depth = -test.surface().position_view.at(x, y, 2);
      for (std::size_t i = 0; i < 4; ++i) {
        const GBufferImages& layer = hidden.images[i];
        const float side = layer.mask.at(x, y);
        if (side == 0.0f) {
          EXPECT_EQ(pixel3(layer.position_view, x, y), glm::dvec3(0));
          continue;
        }
        EXPECT_GT(-layer.position_view.at(x, y, 2), depth) << x << " " << y << " " << i;
        depth = -layer.position_view.at(x, y, 2);
        EXPECT_EQ(side, i % 2 == 0 ? 2.0f : 1.0f) << x << " " << y << " " << i;
        // Outward: that of the bottom of the slab and of the floor's top are known.
        const glm::vec3 p = world_position(test, layer.position_view, x, y);
        const glm::vec3 n = rotation * glm::vec3(pixel3(layer.normal_view, x, y));
        const bool off_edges = std::abs(p.x) < 0.59f && std::abs(p.z) < 0.49f;
        if (off_edges && std::abs(p.y - 0.5f) < 1e-3f) {
          EXPECT_NEAR(n.y, -1.0f, 1e-4f);
        }
        if (off_edges && std::abs(p.y) < 1e-3f) {
          EXPECT_NEAR(n.y, 1.0f, 1e-4f);
        }
      }
      const bool fourth = hidden.images[2].mask.at(x, y) > 0.0f;
      four += fourth ? 1 : 0;
      two += !fourth && hidden.images[0].mask.at(x, y) > 0.0f ? 1 : 0;
      EXPECT_EQ(hidden.images[3].mask.at(x, y), 0.0f) << "two solids have four surfaces";
    }
  }
  EXPECT_GT(four, 300) << "slab and floor";
  EXPECT_GT(two, 1000) << "floor alone";
}

/// Floor pixels whose shadow of a sun is known: away from its border by `margin`, scene units.
struct ShadowCount {
  int in_shadow = 0, lit = 0, wrongly_lit = 0, wrongly_dark = 0;
};

/// `blocked(p, margin)`: whether the ray from floor point p meets a blocker that is larger by
/// `margin` on all sides.
ShadowCount count_shadow(const TestFrame& test, const Image& radiance,
                         const std::function<bool(glm::vec3, float)>& blocked) {
  constexpr float margin = 0.08f;
  ShadowCount count;
  for (int y = 0; y < test.height(); ++y) {
    for (int x = 0; x < test.width(); ++x) {
      if (test.surface().mask.at(x, y) < 0.5f) continue;
      const glm::vec3 p = world_position(test, test.surface().position_view, x, y);
      if (std::abs(p.y) > 1e-3f || blocked(p, margin) != blocked(p, -margin)) continue;
      const bool dark = radiance.at(x, y, 0) < 1e-6f;
      const bool shadow = blocked(p, 0.0f);
      (shadow ? count.in_shadow : count.lit) += 1;
      count.wrongly_lit += shadow && !dark ? 1 : 0;
      count.wrongly_dark += !shadow && dark ? 1 : 0;
    }
  }
  return count;
}

/// Whether the ray from p meets the box grown by `margin`: the slab method.
bool meets_box(glm::vec3 p, glm::vec3 direction, glm::vec3 low, glm::vec3 high, float margin) {
  float enter = 0.0f, leave = 1e30f;
  for (int axis = 0; axis < 3; ++axis) {
    const float a = (low[axis] - margin - p[axis]) / direction[axis];
    const float b = (high[axis] + margin - p[axis]) / direction[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter < leave;
}

/// The floating slab's shadow as SSDO has it, the sun and the camera low.
ShadowCount slab_shadow(Values values) {
  const glm::vec3 toward_sun = glm::normalize(glm::vec3(0.5f, 1.0f, 0.35f));
  const View low = look_at({0.3f, 1.5f, 4.0f}, {0, 0.2f, 0}, 0.5f, 96, 72);
  const TestFrame test(floating_slab(), low, darkness(), {sun_toward(toward_sun)});
  values.insert(values.end(),
                {{"filter", std::string("none")}, {"steps", 64L}, {"d_max_world", 1.6}});
  return count_shadow(test, test.layer("ssdo", "radiance", values), [&](glm::vec3 p, float margin) {
    return meets_box(p, toward_sun, slab_low, slab_high, margin);
  });
}

TEST(Layers, GiveTheShadowOfAFloatingSlabItsShape) {
  // Behind the slab's first surface a single layer knows no end: its shadow goes on where the sun
  // comes in below. Between its two surfaces it is exact.
  const ShadowCount depth = slab_shadow({{"visibility", std::string("depth")}});
  const ShadowCount peeled = slab_shadow({{"visibility", std::string("peeled")}});
  EXPECT_GT(peeled.in_shadow, 200);
  EXPECT_GT(peeled.lit, 1500);
  EXPECT_GT(depth.wrongly_dark, 50);
  EXPECT_EQ(peeled.wrongly_dark, 0);
  EXPECT_EQ(depth.wrongly_lit, 0);
  EXPECT_EQ(peeled.wrongly_lit, 0);
}

TEST(Layers, BringAmbientOcclusionNearerToTheTracedOne) {
  const TestFrame test(floating_slab(), over_the_slab, constant_environment(glm::vec3(1)));
  const auto error = [&](const std::string& method, const char* visibility) {
    const Values values = {
        {"samples", 64L}, {"steps", 16L}, {"filter", std::string("none")}, {"d_max_world", 1.5}};
    Values own = values;
    own.emplace_back("visibility", std::string(visibility));
    Values traced = values;
    traced.emplace_back("visibility", std::string("traced"));
    const Image k = test.layer(method, "radiance", own);
    const Image truth = test.layer(method, "radiance", traced);
    double sum = 0.0;
    for (std::size_t i = 0; i < k.values().size(); ++i) {
      sum += std::abs(double(k.values()[i]) - double(truth.values()[i]));
    }
    return sum / double(k.values().size());
  };
  for (const std::string& method : screen_space_methods) {
    EXPECT_LT(error(method, "peeled"), 0.5 * error(method, "depth")) << method;
    EXPECT_GT(error(method, "depth"), 0.005) << method;
  }
}

TEST(Layers, MoreThanTwoFindABlockerBehindABlocker) {
  // A board near the camera hides the slab: of the slab's two surfaces, two layers know none.
  SceneBuilder scene;
  scene.add_box({-3, -0.3f, -3}, {3, 0, 3});
  scene.add_box(slab_low, slab_high);
  scene.add_box({-0.25f, 0.7f, 1.7f}, {0.6f, 1.5f, 1.75f});
  const glm::vec3 toward_sun = glm::normalize(glm::vec3(1.5f, 1.0f, 0.0f));
  const TestFrame test(scene.build(), over_the_slab, darkness(), {sun_toward(toward_sun)});
  const auto wrongly_lit = [&](long layers) {
    const Image radiance = test.layer("ssdo", "radiance",
                                      {{"visibility", std::string("peeled")},
                                       {"layers", layers},
                                       {"filter", std::string("none")},
                                       {"steps", 64L},
                                       {"d_max_world", 1.5}});
    return count_shadow(test, radiance,
                        [&](glm::vec3 p, float margin) {
                          return meets_box(p, toward_sun, slab_low, slab_high, margin);
                        })
        .wrongly_lit;
  };
  EXPECT_GT(wrongly_lit(2), 50);
  EXPECT_EQ(wrongly_lit(4), 0);
}

TEST(Layers, OfAnOpenMeshCountAsASingleLayerAndAreCounted) {
  // A floor without a back: nothing lies behind it, and everything below counts as solid.
  const TestFrame test(floor_and_tall_wall(), look_at({4, 3, 2}, {0.5f, 0.3f, 0}, 0.5f, 48, 36),
                       constant_environment(glm::vec3(1)));
  Metadata facts;
  const Layers peeled = test.evaluate("ssao", {{"visibility", std::string("peeled")}}, &facts);
  const Image depth = test.layer("ssao", "radiance", {});
  EXPECT_EQ(peeled.at("radiance"), depth);
  EXPECT_EQ(facts.at("open_mesh_pixels"), std::to_string(48 * 36));
  EXPECT_EQ(facts.at("overlapping_solid_pixels"), "0");
  ASSERT_EQ(warnings(facts).size(), 1u);
  EXPECT_NE(warnings(facts).front().find("1728 pixels show open meshes"), std::string::npos);

  const TestFrame closed(floating_slab(), over_the_slab, constant_environment(glm::vec3(1)));
  closed.evaluate("ssao", {{"visibility", std::string("peeled")}, {"layers", 6L}, {"samples", 4L}},
                  &facts);
  EXPECT_EQ(facts.at("open_mesh_pixels"), "0");
  EXPECT_EQ(facts.at("overlapping_solid_pixels"), "0");
  EXPECT_EQ(facts.at("full_layer_pixels"), "0");
  EXPECT_TRUE(warnings(facts).empty());
}

TEST(Layers, SidesAreCountedByWhatTheyAreOf) {
  // One pixel each: closed; nested; open behind a front; a back first; full.
  const auto count = [](std::vector<float> sides) {
    std::vector<Image> layers;
    for (const float side : sides) layers.emplace_back(1, 1, 1, side);
    return count_sides(layers);
  };
  EXPECT_EQ(count({1, 2, 1, 2, 0}).open_mesh_pixels, 0u);
  EXPECT_EQ(count({1, 2, 1, 2, 0}).overlapping_pixels, 0u);
  EXPECT_EQ(count({1, 1, 2, 2, 0}).open_mesh_pixels, 0u);
  EXPECT_EQ(count({1, 1, 2, 2, 0}).overlapping_pixels, 1u);
  EXPECT_EQ(count({1, 0}).open_mesh_pixels, 1u);
  EXPECT_EQ(count({1, 1, 2, 0}).open_mesh_pixels, 1u);
  EXPECT_EQ(count({2, 1, 2}).open_mesh_pixels, 1u);
  EXPECT_EQ(count({1, 2}).full_pixels, 1u);
  EXPECT_EQ(count({1, 1}).open_mesh_pixels, 0u) << "there may be more behind";
  EXPECT_EQ(count({0, 0}).open_mesh_pixels, 0u);
}

TEST(Layers, OfMirroredInstancesAreSeenFromTheirRightSide) {
  Scene scene = floating_slab();
  for (Instance& instance : scene.instances) instance.world_from_object[0][0] = -1.0f;
  const TestFrame test(scene, over_the_slab, constant_environment(glm::vec3(1)));
  Metadata facts;
  test.evaluate("ssao", {{"visibility", std::string("peeled")}, {"layers", 6L}, {"samples", 4L}},
                &facts);
  EXPECT_EQ(facts.at("open_mesh_pixels"), "0");
}

/// A board that hides a post from the camera; the sun behind them throws the post's shadow to where
/// it is seen.
constexpr glm::vec3 post_low(-0.15f, 0, -1.2f);
constexpr glm::vec3 post_high(0.15f, 0.8f, -0.9f);

Scene hidden_post() {
  SceneBuilder scene;
  scene.add_box({-3, -0.3f, -3}, {3, 0, 3});
  scene.add_box(post_low, post_high);
  scene.add_box({-0.35f, 0, 1.2f}, {0.35f, 1.6f, 1.3f});
  return scene.build();
}

const View before_the_board = look_at({0, 1.3f, 5.0f}, {0, 0.5f, 0}, 0.6f, 96, 72);

TEST(Cameras, ThrowTheShadowOfWhatTheViewDoesNotSee) {
  const glm::vec3 toward_sun = glm::normalize(glm::vec3(-1.0f, 0.8f, -0.2f));
  const TestFrame test(hidden_post(), before_the_board, darkness(), {sun_toward(toward_sun)});
  const auto shadow = [&](const char* visibility) {
    const Image radiance = test.layer("ssdo", "radiance",
                                      {{"visibility", std::string(visibility)},
                                       {"camera_scale", 2.0},
                                       {"filter", std::string("none")},
                                       {"steps", 64L},
                                       {"d_max_world", 1.4}});
    return count_shadow(test, radiance, [&](glm::vec3 p, float margin) {
      if (p.x < 0.3f || p.z > 0.5f) return margin > 0.0f;  // not looked at
      return meets_box(p, toward_sun, post_low, post_high, margin);
    });
  };
  const ShadowCount one = shadow("depth");
  const ShadowCount several = shadow("multiview");
  EXPECT_GT(one.wrongly_lit, 0.8 * one.in_shadow) << "the post is not among the first surfaces";
  EXPECT_LT(several.wrongly_lit, 0.05 * one.wrongly_lit);
}

TEST(Cameras, LookAtWhatIsInTheMiddleOfTheView) {
  const TestFrame test(hidden_post(), before_the_board, constant_environment(glm::vec3(1)));
  const Frame& frame = test.frame();
  const float radius = frame.scene.bounding_radius();
  const HiddenSettings settings{.kind = HiddenKind::cameras, .count = 4};
  const HiddenImages& hidden = frame.hidden_images(settings);
  ASSERT_EQ(hidden.cameras.size(), 4u);
  const glm::vec3 middle(pixel3(test.surface().position_view, 48, 36));
  for (std::size_t i = 0; i < 4; ++i) {
    const HiddenCamera& camera = hidden.cameras[i];
    EXPECT_EQ(camera.view.width, 48);
    EXPECT_EQ(camera.view.height, 36);
    const glm::vec3 there(camera.camera_from_view * glm::vec4(middle, 1.0f));
    EXPECT_NEAR(there.x, 0.0f, 1e-4f);
    EXPECT_NEAR(there.y, 0.0f, 1e-4f);
    EXPECT_LT(there.z, 0.0f);
    const glm::vec3 eye(glm::inverse(camera.camera_from_view)[3]);
    EXPECT_NEAR(glm::length(eye), radius, 1e-4f * radius);
    EXPECT_GT(eye.y, 0.3f * radius) << "above the view's";
    // What it shows is in the view's own space: it projects where it is seen.
    const GBufferImages& images = hidden.images[i];
    int seen = 0;
    for (int y = 0; y < 36; ++y) {
      for (int x = 0; x < 48; ++x) {
        if (images.mask.at(x, y) == 0.0f) continue;
        ++seen;
        const glm::vec3 own(camera.camera_from_view *
                            glm::vec4(glm::vec3(pixel3(images.position_view, x, y)), 1.0f));
        const float focal = camera.view.focal_pixels();
        EXPECT_NEAR(24.0f - focal * own.x / own.z, float(x) + 0.5f, 2e-3f);
        EXPECT_NEAR(18.0f + focal * own.y / own.z, float(y) + 0.5f, 2e-3f);
        EXPECT_EQ(images.mask.at(x, y), 1.0f);
      }
    }
    EXPECT_GT(seen, 400);
  }
  EXPECT_LT(glm::inverse(hidden.cameras[3].camera_from_view)[3].x,
            glm::inverse(hidden.cameras[0].camera_from_view)[3].x);
}

TEST(Cameras, TakeAwayTheShadowBehindWhatIsInFrontOfTheView) {
  // What the view takes for solid behind the slab, the others see to be free.
  const ShadowCount one = slab_shadow({{"visibility", std::string("depth")}});
  const ShadowCount several =
      slab_shadow({{"visibility", std::string("multiview")}, {"camera_scale", 2.0}});
  EXPECT_GT(one.wrongly_dark, 50);
  EXPECT_LT(several.wrongly_dark, 0.1 * one.wrongly_dark);
  EXPECT_LT(several.wrongly_lit, 0.02 * several.in_shadow);
}

TEST(Cameras, ThatSeeBacksOrNothingTellNothing) {
  const View above = look_at({0, 2, 4}, {0, 0.3f, 0}, 0.6f, 48, 36);
  SceneBuilder scene;
  scene.add(quad({-9, 0, -9}, {0, 0, 18}, {18, 0, 0}));
  scene.add(quad({-0.5f, 0, 0}, {1.0f, 0, 0}, {0, 1.0f, 0}));
  scene.add_box({-30, 10, -30}, {30, 70, 30});
  const TestFrame test(scene.build(), above, constant_environment(glm::vec3(1)));
  // Up by half of the scene's radius: inside of the box.
  Metadata facts;
  const Values inside = {
      {"visibility", std::string("multiview")}, {"cameras", 1L}, {"camera_offset", 0.5}};
  const Layers seen = test.evaluate("ssao", inside, &facts);
  EXPECT_EQ(facts.at("camera_back_share"), "1.000");
  EXPECT_EQ(facts.at("cameras_blind"), "0");
  EXPECT_TRUE(warnings(facts).empty());
  EXPECT_EQ(seen.at("radiance"), test.layer("ssao", "radiance", {}));
  EXPECT_EQ(warnings({{"cameras_blind", "2"}}).size(), 1u);
}

}  // namespace
}  // namespace occlab::test
