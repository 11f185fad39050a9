// Punctual lights in the passes, and cones.

#include <gtest/gtest.h>

#include "renderers/shared/representation_bent_cone.h"
#include "renderers/shared/sh.h"
#include "tests/analytic/traced_points.h"
#include "tests/gpu/gpu_frame.h"

namespace occlab::test {
namespace {

const View corner_view = look_at({5, 4, 3}, {0.3f, 0.4f, 0}, 0.4f, 48, 36);
const Environment black = constant_environment(glm::vec3(0.0f));

Light directional(glm::vec3 travel, glm::vec3 intensity) {
  return {.name = "sun",
          .type = LightType::directional,
          .direction_world = glm::normalize(travel),
          .intensity = intensity};
}

glm::vec3 normal_at(const TestFrame& frame, int x, int y) {
  return glm::vec3(pixel3(frame.surface().normal_view, x, y));
}

template <typename Body>
void for_each_surface(const TestFrame& frame, const Body& body) {
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) {
      if (frame.surface().mask.at(x, y) > 0.0f) body(x, y);
    }
  }
}

TEST(DirectionalLight, SsaoScalesItByTheOcclusion) {
  const Light sun = directional({-1, -2, -0.5f}, {3, 2, 1});
  const TestFrame frame(floor_and_tall_wall(4.0f), corner_view, black, {sun});
  const glm::vec3 toward(frame.frame().view.view_from_world() *
                         glm::vec4(-sun.direction_world, 0.0f));
  const Layers layers = frame.evaluate("ssao", {});
  for_each_surface(frame, [&](int x, int y) {
    const float E = std::max(glm::dot(normal_at(frame, x, y), toward), 0.0f);
    const float k = layers.at("ambient_occlusion").at(x, y);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(layers.at("radiance").at(x, y, c), sun.intensity[c] * k * E / pi, 1e-5f);
    }
  });
}

TEST(DirectionalLight, S3hoTakesItsWindowedHarmonics) {
  const Light sun = directional({-1, -2, -0.5f}, {3, 2, 1});
  const TestFrame frame(floor_and_tall_wall(4.0f), corner_view, black, {sun});
  const glm::vec3 toward(frame.frame().view.view_from_world() *
                         glm::vec4(-sun.direction_world, 0.0f));
  for (const double width : {0.0, 4.0, 2.5}) {
    const Layers layers = frame.evaluate("s3ho", {{"hanning_width", width}});
    for_each_surface(frame, [&](int x, int y) {
      const auto c = layers.at("sh_visibility").pixel(x, y);
      const Sh4 visibility{vec4(c[0], c[1], c[2], c[3]), vec4(c[4], c[5], c[6], c[7]),
                           vec4(c[8], c[9], c[10], c[11]), vec4(c[12], c[13], c[14], c[15])};
      vec4 window(1.0f);
      for (int l = 0; l < 4 && width > 0.0; ++l) {
        window[l] = l < width ? float(0.5 * (1.0 + std::cos(pi_d * l / width))) : 0.0f;
      }
      const float E = sh_dot(sh_scale_bands(sh_basis(toward), window), visibility);
      for (int channel = 0; channel < 3; ++channel) {
        EXPECT_NEAR(layers.at("radiance").at(x, y, channel),
                    std::max(sun.intensity[channel] * E / pi, 0.0f), 1e-5f);
      }
    });
  }
  // Head-on, unoccluded: 17/16 of E_perp without a window, .833027 with w = 4.
  const TestFrame open(open_floor(), corner_view, black, {directional({0, -1, 0}, glm::vec3(1))});
  for (const auto& [width, response] : {std::pair(0.0, 17.0 / 16.0), std::pair(4.0, 0.833027)}) {
    const Image radiance =
        open.layer("s3ho", "radiance", {{"hanning_width", width}, {"samples", 256L}});
    EXPECT_NEAR(radiance.at(20, 20) * pi_d, response, 3e-3);
  }
}

TEST(DirectionalLight, SsdoMarchesTowardIt) {
  // From behind the wall at 45 degrees: the floor is in shadow up to the reach of the march, and
  // lit where a blocker is too far away.
  const Light sun = directional({1, -1, 0}, glm::vec3(1.0f));
  const TestFrame frame(floor_and_tall_wall(4.0f), look_at({7, 3, 0}, {0, 0.9f, 0}, 0.5f, 48, 60),
                        black, {sun});
  const Image radiance =
      frame.layer("ssdo", "radiance", {{"filter", "none"}, {"steps", 64L}, {"bias_world", 1e-4}});
  int shadowed = 0, lit = 0;
  for_each_surface(frame, [&](int x, int y) {
    const glm::vec3 p(frame.frame().view.camera.world_from_camera *
                      glm::vec4(glm::vec3(pixel3(frame.surface().position_view, x, y)), 1.0f));
    if (p.y > 1e-3f) {
      EXPECT_EQ(radiance.at(x, y), 0.0f) << "the wall faces away";
    } else if (p.x < 0.6f && p.x > 0.1f) {
      EXPECT_EQ(radiance.at(x, y), 0.0f) << p.x;
      ++shadowed;
    } else if (p.x > 0.75f) {  // the wall is farther than d_max = 1 along the light: x sqrt(2)
      EXPECT_NEAR(radiance.at(x, y), std::sqrt(0.5) / pi_d, 1e-5) << p.x;
      ++lit;
    }
  });
  EXPECT_GT(shadowed, 50);
  EXPECT_GT(lit, 200);
}

TEST(DirectionalLight, SsbnLightsWhatLiesInTheCone) {
  const Light sun = directional({-1, -2, -0.5f}, glm::vec3(1.0f));
  const TestFrame frame(floor_and_tall_wall(4.0f), corner_view, black, {sun});
  const glm::vec3 toward(frame.frame().view.view_from_world() *
                         glm::vec4(-sun.direction_world, 0.0f));
  for (const char* mode : {"linear", "exact"}) {
    const Layers layers = frame.evaluate("ssbn", {{"cone_angle", mode}});
    int edge = 0;
    for_each_surface(frame, [&](int x, int y) {
      const glm::dvec3 bent = pixel3(layers.at("bent_normal"), x, y);
      const double cap = std::clamp(2.0 * glm::length(bent) - 1.0, 0.0, 1.0);
      const double C = std::string(mode) == "exact" ? std::acos(cap) : (1.0 - cap) * pi_d / 2;
      const glm::dvec3 N = glm::normalize(bent);
      const double cosine = glm::dot(N, glm::dvec3(toward));
      if (std::abs(cosine - std::cos(C)) < 1e-3) {
        ++edge;
        return;
      }
      const double L =
          cosine > std::max(std::cos(C), 0.0) ? cosine / (1.0 - std::cos(C)) / pi_d : 0.0;
      const double expected = double(layers.at("uniform_occlusion").at(x, y)) * L *
                              glm::dot(N, glm::dvec3(normal_at(frame, x, y)));
      EXPECT_NEAR(layers.at("radiance").at(x, y), expected, 2e-3 * expected + 1e-6) << mode;
    });
    EXPECT_LT(edge, 200);
  }
  // Unoccluded it is the light itself: E_perp cos.
  const TestFrame open(open_floor(), corner_view, black, {directional({-1, -2, 0}, glm::vec3(1))});
  EXPECT_NEAR(open.layer("ssbn", "radiance", {{"samples", 256L}}).at(20, 20),
              2.0 / std::sqrt(5.0) / pi_d, 2e-3);
}

TEST(ConeLight, IsThatOfTheBentConeUnderALinearSky) {
  // L = a + b.w: (t/pi) int_cone L cos = t (a sin^2 C + (2/3)(1 - cos^3 C) b.N), t = 1/(1 - cos C).
  const double a = 1.0;
  const glm::dvec3 b(0.5, 0.4, -0.6);
  const TestFrame frame(floor_and_tall_wall(4.0f), corner_view, probe_of(256, [&](glm::vec3 d) {
                          return glm::vec3(float(a + glm::dot(b, glm::dvec3(d))));
                        }));
  const glm::dvec3 b_view(glm::mat3(frame.frame().view.view_from_world()) * glm::vec3(b));
  for (const char* mode : {"linear", "exact"}) {
    const Layers layers = frame.evaluate("ssbn", {{"cone_angle", mode}, {"d_max_world", 2.0}});
    double narrowest = pi_d;
    for_each_surface(frame, [&](int x, int y) {
      const glm::dvec3 bent = pixel3(layers.at("bent_normal"), x, y);
      const double cap = std::clamp(2.0 * glm::length(bent) - 1.0, 0.0, 1.0);
      const double C = std::string(mode) == "exact" ? std::acos(cap) : (1.0 - cap) * pi_d / 2;
      narrowest = std::min(narrowest, C);
      const double c = std::cos(C);
      const glm::dvec3 N = glm::normalize(bent);
      const double L =
          (a * (1 - c * c) + 2.0 / 3.0 * (1 - c * c * c) * glm::dot(b_view, N)) / (1 - c);
      const double expected = double(layers.at("uniform_occlusion").at(x, y)) * L *
                              glm::dot(N, glm::dvec3(normal_at(frame, x, y)));
      // Linear between levels 11.25 degrees apart: below 1% of the light.
      EXPECT_NEAR(layers.at("radiance").at(x, y), expected, 0.01 * expected) << mode << " " << C;
    });
    EXPECT_LT(narrowest, 1.3) << "there are cones between other levels than the last two";
  }
}

TEST(PointLight, FallsOffWithTheSquareOfTheDistance) {
  Light lamp{.name = "lamp", .position_world = {0.5f, 2, 0.25f}, .intensity = {4, 2, 1}};
  const TestFrame frame(open_floor(), corner_view, black, {lamp});
  const glm::vec3 at(frame.frame().view.view_from_world() * glm::vec4(lamp.position_world, 1.0f));
  for (const char* method : {"ssao", "ssdo"}) {
    const Image radiance = frame.layer(method, "radiance", {{"filter", "none"}});
    for_each_surface(frame, [&](int x, int y) {
      const glm::vec3 d = at - glm::vec3(pixel3(frame.surface().position_view, x, y));
      const float E = glm::dot(normal_at(frame, x, y), d) / std::pow(glm::length(d), 3.0f);
      EXPECT_NEAR(radiance.at(x, y, 1), 2.0f * E / pi, 1e-4f * E) << method;
    });
  }
}

TEST(PointLight, SsdoMarchesTowardItAsFarAsRMaxAndNoFarther) {
  // [SSDO sec. 4] Screen-space shadows of a point light: samples on a segment of length r_max
  // toward it. From behind the wall the lamp lights no floor; the march finds that out where the
  // wall is within r_max along the segment, to a step and a pixel (.043 wide).
  const double r_max = 0.9;
  constexpr long steps = 64;
  const glm::vec3 behind(-2.0f, 1.5f, 0.3f);
  const Values values = {
      {"filter", "none"}, {"steps", steps}, {"d_max_world", r_max}, {"bias_world", 1e-4}};
  const View view = look_at({3, 2.5f, 1.5f}, {0.4f, 0, 0}, 0.5f, 64, 48);
  const TestFrame blocked(floor_and_tall_wall(), view, black,
                          {{.name = "lamp", .position_world = behind, .intensity = glm::vec3(5)}});
  const Image irradiance = blocked.layer("ssdo", "irradiance", values);
  int dark = 0, lit = 0;
  for_each_surface(blocked, [&](int x, int y) {
    const glm::vec3 p(view.camera.world_from_camera *
                      glm::vec4(glm::vec3(pixel3(blocked.surface().position_view, x, y)), 1.0f));
    if (p.y > 1e-3f || p.x < 0.05f) return;
    const glm::dvec3 to_lamp = glm::dvec3(behind) - glm::dvec3(p);
    const double to_wall = glm::length(to_lamp) * double(p.x) / double(p.x - behind.x);
    const double E = double(irradiance.at(x, y));
    if (to_wall < r_max * (1.0 - 1.0 / steps) - 0.06) {
      EXPECT_EQ(E, 0.0) << x << " " << y;
      ++dark;
    } else if (to_wall > r_max) {
      const double d = glm::length(to_lamp);
      EXPECT_NEAR(E, 5.0 * to_lamp.y / (d * d * d), 1e-5) << x << " " << y;
      ++lit;
    }
  });
  EXPECT_GT(dark, 200);
  EXPECT_GT(lit, 200);
  // What is behind the lamp blocks nothing, however large r_max is.
  const glm::vec3 before(0.3f, 0.6f, 0.0f);
  const TestFrame open(floor_and_tall_wall(), view, black,
                       {{.name = "lamp", .position_world = before, .intensity = glm::vec3(5)}});
  Values far = values;
  far[2].second = 5.0;
  const Image unblocked = open.layer("ssdo", "irradiance", far);
  for_each_surface(open, [&](int x, int y) {
    const glm::vec3 p(view.camera.world_from_camera *
                      glm::vec4(glm::vec3(pixel3(open.surface().position_view, x, y)), 1.0f));
    if (p.y > 1e-3f || p.x < 0.05f) return;
    EXPECT_GT(unblocked.at(x, y), 0.0f) << x << " " << y;
  });
}

TEST(ThreeBoxes, ShadowsSwapColourWhenTheLightsSwap) {
  // The paper's Fig. 5. Light adds up: with A and B what either light of unit white gives, the
  // scene is A a + B b in its colours a, b, and A b + B a with them swapped.
  const Scene scene =
      load_scene(std::string(OCCLAB_SOURCE_DIR) + "/scenes/three_boxes/three_boxes.glb");
  ASSERT_EQ(scene.lights.size(), 2u);
  const View view{scene.cameras.front(), 96, 54};
  const auto render = [&](const std::string& method, glm::vec3 first, glm::vec3 second) {
    std::vector<Light> lights = scene.lights;
    lights[0].intensity = first;
    lights[1].intensity = second;
    const TestFrame frame(scene, view, black, lights);
    // Unwindowed negative lobes would be cut off, and cut values do not add up.
    return frame.layer(method, "radiance", {{"d_max_world", 2.0}, {"hanning_width", 2.5}});
  };
  const glm::vec3 pink = scene.lights[0].intensity, turquoise = scene.lights[1].intensity;
  const double scale = double(glm::length(pink));
  for (const char* method : {"s3ho", "ssdo"}) {
    const Image A = render(method, glm::vec3(1), glm::vec3(0));
    const Image B = render(method, glm::vec3(0), glm::vec3(1));
    const Image both = render(method, pink, turquoise);
    const Image swapped = render(method, turquoise, pink);
    int shadows = 0, cut = 0;
    for (int y = 0; y < view.height; ++y) {
      for (int x = 0; x < view.width; ++x) {
        const double a = double(A.at(x, y)), b = double(B.at(x, y));
        if (a == 0.0 || b == 0.0) {
          ++cut;  // perhaps below zero
          continue;
        }
        for (int c = 0; c < 3; ++c) {
          const double plain = a * double(pink[c]) + b * double(turquoise[c]);
          const double exchanged = a * double(turquoise[c]) + b * double(pink[c]);
          EXPECT_NEAR(both.at(x, y, c), plain, 1e-4 * scale);
          EXPECT_NEAR(swapped.at(x, y, c), exchanged, 1e-4 * scale);
        }
        // Where one light is shadowed, the pixel has the other's colour.
        if (a < 0.5 * b || b < 0.5 * a) {
          ++shadows;
          const glm::dvec3 colour(a < b ? turquoise : pink), other(a < b ? pink : turquoise);
          const auto angle = [](glm::dvec3 u, glm::dvec3 v) {
            return std::acos(std::min(1.0, glm::dot(glm::normalize(u), glm::normalize(v))));
          };
          EXPECT_LT(angle(pixel3(both, x, y), colour), angle(pixel3(both, x, y), other));
          EXPECT_LT(angle(pixel3(swapped, x, y), other), angle(pixel3(swapped, x, y), colour));
        }
      }
    }
    EXPECT_GT(shadows, 20) << method;
    EXPECT_LT(cut, view.width * view.height) << method;
  }
}

}  // namespace
}  // namespace occlab::test
