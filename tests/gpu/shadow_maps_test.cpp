// Lights with shadow maps: where shadows begin and end, what the bias does, what screen space
// brings back of what it took.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "renderers/methods/mapped_lights.h"
#include "renderers/scene/error.h"
#include "renderers/shared/shadow_map.h"
#include "tests/gpu/gpu_frame.h"

namespace occlab::test {
namespace {

const Environment black = constant_environment(glm::vec3(0.0f));

Light lamp_at(glm::vec3 position, float intensity = 10.0f) {
  return {.name = "lamp", .position_world = position, .intensity = glm::vec3(intensity)};
}

Light sun_along(glm::vec3 travel) {
  return {.name = "sun",
          .type = LightType::directional,
          .direction_world = glm::normalize(travel),
          .intensity = glm::vec3(1.0f)};
}

/// Six outward faces.
void add_box(SceneBuilder& builder, glm::vec3 low, glm::vec3 high) {
  const glm::vec3 d = high - low;
  const glm::vec3 x(d.x, 0, 0), y(0, d.y, 0), z(0, 0, d.z);
  builder.add(quad(low, x, z)).add(quad(low + y, z, x));
  builder.add(quad(low, y, x)).add(quad(low + z, x, y));
  builder.add(quad(low, z, y)).add(quad(low + x, y, z));
}

SceneBuilder floor_of(float half) {
  SceneBuilder builder;
  builder.add(quad({-half, 0, -half}, {0, 0, 2 * half}, {2 * half, 0, 0}));
  return builder;
}

const Values no_environment = {{"environment_lights", 0L}};

Values with(Values values, const Values& more) {
  values.insert(values.end(), more.begin(), more.end());
  return values;
}

glm::vec3 world_of(const TestFrame& frame, int x, int y) {
  return glm::vec3(frame.frame().view.camera.world_from_camera *
                   glm::vec4(glm::vec3(pixel3(frame.surface().position_view, x, y)), 1.0f));
}

/// Calls body(x, y, world position) where a surface with normal +Y at height 0 is seen.
template <typename Body>
void for_each_floor_pixel(const TestFrame& frame, const Body& body) {
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) {
      if (frame.surface().mask.at(x, y) == 0.0f) continue;
      const glm::vec3 p = world_of(frame, x, y);
      if (std::abs(p.y) < 1e-4f) body(x, y, p);
    }
  }
}

TEST(ShadowMaps, ShadowOfABoardEndsWhereItMust) {
  // A board 1x1 at height 1 under a lamp at height 4: its shadow is a square of 4/3 a side.
  SceneBuilder builder = floor_of(3.0f);
  builder.add(quad({-0.5f, 1, -0.5f}, {0, 0, 1}, {1, 0, 0}));
  const Scene scene = builder.build();
  const View view = look_at({2.6f, 0.8f, 1.9f}, {0, 0, 0}, 0.8f, 96, 96);
  for (const bool parallel : {false, true}) {
    const Light light = parallel ? sun_along({0, -1, 0}) : lamp_at({0, 4, 0});
    const TestFrame frame(scene, view, black, {light});
    for (const long side : {64L, 512L}) {
      const Layers layers = frame.evaluate(
          "shadow_maps",
          with(no_environment, {{"shadow_map_side", side}, {"correction_samples", 0L}}));
      const double half = parallel ? 0.5 : 2.0 / 3.0;
      // The cube's face is 8 wide at the floor; the parallel map as wide as the sphere.
      const double texel = (parallel ? 2.0 * double(scene.bounding_radius()) : 8.0) / double(side);
      int lit = 0, dark = 0;
      for_each_floor_pixel(frame, [&](int x, int y, glm::vec3 p) {
        const double beyond = std::max(std::abs(double(p.x)), std::abs(double(p.z))) - half;
        if (std::abs(beyond) < texel) return;
        const double E = double(layers.at("irradiance").at(x, y));
        const double d2 = double(glm::dot(glm::vec3(0, 4, 0) - p, glm::vec3(0, 4, 0) - p));
        const double expected = parallel ? 1.0 : 10.0 * 4.0 / (d2 * std::sqrt(d2));
        if (beyond > 0.0) {
          EXPECT_NEAR(E, expected, 1e-4 * expected) << side << ": " << x << " " << y;
          ++lit;
        } else {
          EXPECT_EQ(E, 0.0) << side << ": " << x << " " << y;
          ++dark;
        }
      });
      EXPECT_GT(lit, 1000);
      EXPECT_GT(dark, side == 64 ? 150 : 250);
    }
  }
}

/// The share of an open floor's pixels that a light does not reach, though nothing blocks it.
double acne(const Light& light, long side, const char* bias) {
  const TestFrame frame(floor_of(2.0f).build(), look_at({0.3f, 5, 1}, {0, 0, 0}, 0.7f, 64, 64),
                        black, {light});
  const Layers layers =
      frame.evaluate("shadow_maps", with(no_environment, {{"shadow_map_side", side},
                                                          {"shadow_bias", bias},
                                                          {"most_slope", 1000.0},
                                                          {"correction_samples", 0L}}));
  int dark = 0, all = 0;
  for_each_floor_pixel(frame, [&](int x, int y, glm::vec3) {
    ++all;
    dark += layers.at("irradiance").at(x, y) > 0.0f ? 0 : 1;
  });
  EXPECT_GT(all, 2000);
  return double(dark) / all;
}

TEST(ShadowMaps, SlopeBiasRemovesAllSelfShadows) {
  // Any tilt and azimuth; the patch's diagonal is what the worst azimuth needs.
  for (const double tilt : {0.0, 10.0, 30.0, 60.0, 80.0, 88.0}) {
    for (const double azimuth : {0.0, 20.0, 45.0, 110.0}) {
      const double a = tilt * pi_d / 180.0, b = azimuth * pi_d / 180.0;
      const glm::vec3 toward(std::sin(a) * std::cos(b), std::cos(a), std::sin(a) * std::sin(b));
      for (const long side : {33L, 128L}) {
        for (const Light& light : {sun_along(-toward), lamp_at(3.0f * toward)}) {
          EXPECT_EQ(acne(light, side, "slope"), 0.0)
              << light.name << ", tilt " << tilt << ", azimuth " << azimuth << ", side " << side;
        }
      }
      if (tilt >= 30.0 && tilt < 85.0) {
        EXPECT_GT(acne(sun_along(-toward), 128L, "none"), 0.2) << tilt << " " << azimuth;
        EXPECT_GT(acne(lamp_at(3.0f * toward), 128L, "none"), 0.2) << tilt << " " << azimuth;
      }
    }
  }
  // Light along the normal leaves no slope, and so no bias: rounding alone makes no shadows.
  EXPECT_EQ(acne(sun_along({0, -1, 0}), 128L, "none"), 0.0);
}

TEST(ShadowMaps, SpotsAndWideSpotsLightTheSame) {
  // One map of the cone, or a cube's; inside of both cones the same light arrives.
  SceneBuilder builder = floor_of(3.0f);
  add_box(builder, {-0.3f, 0.01f, -0.3f}, {0.3f, 0.6f, 0.3f});
  const Scene scene = builder.build();
  const View view = look_at({0.2f, 6, 2}, {0, 0, 0}, 0.7f, 64, 64);
  std::vector<Image> images;
  for (const float outer : {0.9f, 1.3f}) {
    Light spot = lamp_at({0.5f, 3, 0.2f});
    spot.type = LightType::spot;
    spot.direction_world = {0, -1, 0};
    spot.inner_cone_angle = 0.88f;
    spot.outer_cone_angle = outer;
    const TestFrame frame(scene, view, black, {spot});
    images.push_back(
        frame.evaluate("shadow_maps", with(no_environment, {{"shadow_map_side", 1024L}}))
            .at("irradiance"));
  }
  int compared = 0, different = 0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const float a = images[0].at(x, y), b = images[1].at(x, y);
      const float radius = std::hypot(float(x) - 32.0f, float(y) - 32.0f);
      if (radius > 18.0f) continue;
      ++compared;
      if ((a == 0.0f) != (b == 0.0f)) {
        ++different;  // at a shadow's edge, of which maps differ by a texel
      } else {
        EXPECT_NEAR(a, b, 1e-4f * (1.0f + a)) << x << " " << y;
      }
    }
  }
  EXPECT_GT(compared, 900);
  EXPECT_LT(different, 12);
}

TEST(ShadowMaps, CorrectionBringsContactShadowsBack) {
  // A slab of height h on a floor: its shadow is lost where h < b cos(alpha) = (p/2) sin(alpha),
  // here with .08 against .10, all of it. Its length is .117.
  SceneBuilder builder = floor_of(2.0f);
  add_box(builder, {-0.4f, 0.0f, -0.4f}, {0.4f, 0.08f, 0.4f});
  const TestFrame frame(builder.build(), look_at({0.5f, 2.2f, 2.2f}, {0, 0, 0}, 0.6f, 128, 96),
                        black, {sun_along({1, -0.7f, 0.2f})});
  const Image truth =
      frame.layer("rtdo", "radiance", {{"rays_per_pixel", 16L}, {"d_max_world", 1e3}});
  // Beside the slab, on the side away from the sun, where its shadow lies.
  const auto error = [&](const Values& values) {
    const Image radiance =
        frame.evaluate("shadow_maps", with(no_environment, values)).at("radiance");
    double squares = 0.0;
    int count = 0;
    for_each_floor_pixel(frame, [&](int x, int y, glm::vec3 p) {
      if (p.x < 0.4f || p.x > 0.55f || std::abs(p.z) > 0.4f) return;
      const double e = double(radiance.at(x, y) - truth.at(x, y));
      squares += e * e;
      ++count;
    });
    EXPECT_GT(count, 100);
    return std::sqrt(squares / count);
  };
  const Values coarse = {{"shadow_map_side", 32L}};
  const double fine = error({{"shadow_map_side", 2048L}, {"correction_samples", 0L}});
  const double lost = error(with(coarse, {{"correction_samples", 0L}}));
  const double restored = error(with(coarse, {{"correction_samples", 16L}}));
  EXPECT_LT(fine, 0.3 * lost);
  EXPECT_LT(restored, 0.5 * lost);
}

TEST(ShadowMaps, CorrectionNeverLightsNorDarkensAnOpenFloor) {
  for (const Light& light : {sun_along({1, -0.3f, 0.2f}), lamp_at({1, 0.5f, 0.3f})}) {
    const TestFrame frame(floor_of(2.0f).build(), look_at({0, 3, 3}, {0, 0, 0}, 0.7f, 48, 48),
                          black, {light});
    const auto irradiance = [&](long samples) {
      return frame
          .evaluate("shadow_maps", with(no_environment, {{"shadow_map_side", 32L},
                                                         {"correction_samples", samples}}))
          .at("irradiance");
    };
    const Image plain = irradiance(0), corrected = irradiance(64);
    for (std::size_t i = 0; i < plain.values().size(); ++i) {
      EXPECT_EQ(plain.values()[i], corrected.values()[i]) << i;
    }
  }
}

TEST(ShadowMaps, PeeledCorrectionIsNotFooledByWhatStandsInFront) {
  // A thin box stands upright between the camera and a floor that the sun reaches. What it hides is
  // not in its shadow, but with one depth layer all behind it counts as solid.
  SceneBuilder builder = floor_of(2.0f);
  add_box(builder, {-0.5f, 0.1f, 0.3f}, {0.5f, 0.3f, 0.34f});
  const TestFrame frame(builder.build(), look_at({0, 1.4f, 2.2f}, {0, 0, 0}, 0.5f, 96, 72), black,
                        {sun_along({0.8f, -0.7f, 0.3f})});
  const auto lit_share = [&](const char* visibility, long samples) {
    const Values values = {{"shadow_map_side", 16L},
                           {"d_max_world", 0.6},
                           {"visibility", visibility},
                           {"correction_samples", samples}};
    const Image E = frame.evaluate("shadow_maps", with(no_environment, values)).at("irradiance");
    int lit = 0, all = 0;
    for_each_floor_pixel(frame, [&](int x, int y, glm::vec3 p) {
      // Just above the box in the image, and away from its shadow, which falls to the front.
      if (std::abs(p.x) > 0.3f || p.z > 0.25f || p.z < -0.1f) return;
      ++all;
      lit += E.at(x, y) > 0.0f ? 1 : 0;
    });
    EXPECT_GT(all, 50);
    return double(lit) / all;
  };
  EXPECT_EQ(lit_share("depth", 0), 1.0);
  EXPECT_LT(lit_share("depth", 16), 0.9);
  EXPECT_EQ(lit_share("peeled", 16), 1.0);
}

TEST(ShadowMaps, EnvironmentLightsLightAnOpenFloorAsTheProbeDoes) {
  const Environment sky =
      probe_of(64, [](glm::vec3 d) { return glm::vec3(1.2f + d.x, 1.0f, 1.1f - 0.5f * d.y); });
  const TestFrame frame(open_floor(5.0f), look_at({0, 3, 5}, {0, 0, 0}, 0.6f, 32, 24), sky);
  const Layers layers =
      frame.evaluate("shadow_maps", {{"shadow_map_side", 64L}, {"most_slope", 1e4}});
  const std::vector<MappedLight> lights =
      environment_lights(sky, 256, 0, sphere_around(open_floor(5.0f)));
  glm::dvec3 expected(0.0);
  for (const MappedLight& light : lights) {
    const double cosine = std::max(0.0, -double(light.light.direction_and_outer.y));
    expected += cosine * glm::dvec3(glm::vec3(light.light.intensity_and_inner));
  }
  for_each_floor_pixel(frame, [&](int x, int y, glm::vec3) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(double(layers.at("irradiance").at(x, y, c)), expected[c], 1e-3 * expected[c]);
    }
  });
}

TEST(ShadowMaps, SayWhatCannotBeDone) {
  const View view = look_at({0, 3, 5}, {0, 0, 0}, 0.6f, 16, 16);
  const TestFrame unlit(open_floor(), view, black);
  try {
    unlit.evaluate("shadow_maps", no_environment);
    FAIL() << "nothing lights the scene";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("environment_lights"), std::string::npos);
  }
  Metadata facts;
  unlit.evaluate("shadow_maps", {}, &facts);
  EXPECT_EQ(facts.at("environment_lights"), "0");  // black
  device();
  try {
    const ShadowMaps too_large(1 << 20, 1);
    FAIL() << "no device takes such a map";
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find("shadow_map_side"), std::string::npos);
  }
}

TEST(ShadowMaps, LightsInOddPlacesGiveFiniteLight) {
  // On the floor, inside of a box, at the camera, and a camera that sees nothing.
  SceneBuilder builder = floor_of(2.0f);
  add_box(builder, {-0.5f, 0.0f, -0.5f}, {0.5f, 1.0f, 0.5f});
  const Scene scene = builder.build();
  const glm::vec3 eye(2, 3, 4);
  for (const glm::vec3& place : {glm::vec3(1, 0, 1), glm::vec3(0, 0.5f, 0), eye}) {
    const TestFrame frame(scene, look_at(eye, {0, 0, 0}, 0.6f, 32, 24), black, {lamp_at(place)});
    const Image radiance = frame.evaluate("shadow_maps", no_environment).at("radiance");
    for (const float value : radiance.values()) ASSERT_TRUE(std::isfinite(value));
    if (place == glm::vec3(0, 0.5f, 0)) {
      // Nothing leaves the box.
      EXPECT_EQ(std::ranges::max(radiance.values()), 0.0f);
    }
  }
  const TestFrame away(scene, look_at(eye, {5, 6, 9}, 0.6f, 16, 16), black, {lamp_at({0, 2, 0})});
  EXPECT_EQ(std::ranges::max(away.evaluate("shadow_maps", no_environment).at("radiance").values()),
            0.0f);
}

}  // namespace
}  // namespace occlab::test
