// One traced bounce where the answer has a closed form and no scene file can say it: surfaces that
// are not white, and lights.

#include <gtest/gtest.h>

#include "renderers/shared/visibility.h"
#include "tests/analytic/built_scenes.h"
#include "tests/analytic/traced_points.h"

namespace occlab::test {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

/// One bounce of 2048 rays, d_max = 1.
TraceSettings bounce_of(SentLight sent, const Scene& scene) {
  return {.rays_per_pixel = 2048,
          .d_max_world = 1.0f,
          .bounce = TracedBounce{.sent = sent, .scene = &scene}};
}

std::vector<Mean> radiance_of(const Scene& scene, const Environment& sky, const Point& point,
                              const TraceSettings& settings,
                              const std::vector<Light>& lights = {}) {
  const auto replicates = trace_points(scene, sky, {point}, settings, 64, lights);
  return {mean_of(replicates[0].radiance[0]), mean_of(replicates[0].radiance[1]),
          mean_of(replicates[0].radiance[2])};
}

TEST(TracedBounce, InABowlOfAnyColour) {
  // Every point sees half of the sky: E/pi = k + (1 - k) rho k, with rho = .8 the .7 of one bounce
  // where all bounces give .833 [Stewart and Langer 1997]; unoccluded senders, k + (1 - k) rho.
  constexpr int rings = 96;
  const Scene scene = SceneBuilder()
                          .add(sphere_part({0, 0, 0}, 1.0, 0.5 * pi_d, pi_d, rings))
                          .material({0.8f, 0.4f, 0.0f})
                          .build();
  const double facets = 1.0 - sphere_facet_distance(2 * rings);
  const Point bottom{.position = {0, 0, -1.0 + facets}};
  const Environment white = constant_environment(glm::vec3(1.0f));
  const double rho[3] = {0.8, 0.4, 0.0};
  for (const SentLight sent : {SentLight::shaded, SentLight::unoccluded}) {
    TraceSettings settings = bounce_of(sent, scene);
    settings.d_max_world = infinite;
    const std::vector<Mean> radiance = radiance_of(scene, white, bottom, settings);
    for (std::size_t c = 0; c < 3; ++c) {
      const double sent_share = sent == SentLight::shaded ? 0.5 : 1.0;
      EXPECT_TRUE(agrees(radiance[c], 0.5 + 0.5 * rho[c] * sent_share, 4e-3)) << c;
    }
  }
}

TEST(TracedBounce, WeightsSendersByWhatTheyBlock) {
  // (1 - v) of lambda, d_max = infinity: E/pi of an infinite wall that sends 1 is 1 - k.
  const Scene scene = SceneBuilder().add(quad({0, -1000, 0}, {0, 2000, 0}, {0, 0, 1000})).build();
  TraceSettings settings = bounce_of(SentLight::unoccluded, scene);
  settings.d_max_world = 1e6f;
  settings.weight = weight_lambda;
  for (const double K : {0.3, 3.0}) {
    settings.lambda_per_world = float(K);
    const std::vector<Mean> radiance =
        radiance_of(scene, constant_environment(glm::vec3(1.0f)), {{1, 0, 0}}, settings);
    EXPECT_TRUE(agrees(radiance[0], 1.0, 1e-4)) << K;  // k + (1 - k)
  }
}

/// A floor point beside a wall that faces +X, and a sun that shines on the wall alone.
class LitWall : public testing::Test {
 protected:
  static constexpr double a = 0.25;
  static double share() { return std::acos(a) - a * std::sqrt(1.0 - a * a); }
  static SceneBuilder wall() {
    return SceneBuilder().add(quad({0, -3, 0}, {0, 6, 0}, {0, 0, 3})).material({0.5f, 0.25f, 1});
  }
  static std::vector<Light> sun() {
    return {{.name = "sun",
             .type = LightType::directional,
             .direction_world = {-1, 0, 0},
             .intensity = {2, 3, 4}}};
  }
  static void expect(const Scene& scene, SentLight sent, double factor) {
    const std::vector<Mean> radiance = radiance_of(scene, constant_environment(glm::vec3(0.0f)),
                                                   {{a, 0, 0}}, bounce_of(sent, scene), sun());
    // L_o = rho E_perp/pi of the wall; E = L_o (acos a - a sqrt(1 - a^2)); L = E/pi.
    const double rho[3] = {0.5, 0.25, 1.0};
    const double E_perp[3] = {2, 3, 4};
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_TRUE(agrees(radiance[c], factor * rho[c] * E_perp[c] * share() / (pi_d * pi_d), 1e-5))
          << c;
    }
  }
};

TEST_F(LitWall, SendsItsColour) {
  const Scene scene = wall().build();
  expect(scene, SentLight::shaded, 1.0);
  expect(scene, SentLight::unoccluded, 1.0);
}

TEST_F(LitWall, SendsInItsShadowOnlyUnoccluded) {
  // A board that faces the wall, beyond d_max of the point, within d_max of the wall's points
  // along the light.
  const Scene scene = wall().add(quad({0.9f, -3, 0.9f}, {0, 6, 0}, {0, 0, 9})).build();
  // Directions up to the height .9 of the wall are lit below the board; the shadow begins there, so
  // the point is put under a board that covers all of the wall.
  const Scene covered = wall().add(quad({0.9f, -3, -1}, {0, 6, 0}, {0, 0, 9})).build();
  const Point point{.position = {a, 0, 0}};
  const auto dark = constant_environment(glm::vec3(0.0f));
  const auto of = [&](const Scene& in, SentLight sent) {
    return radiance_of(in, dark, point, bounce_of(sent, in), sun())[2];
  };
  EXPECT_TRUE(agrees(of(covered, SentLight::shaded), 0.0, 0.0));
  // The board's dark side faces the point: it sends nothing, the wall all.
  EXPECT_TRUE(agrees(of(covered, SentLight::unoccluded), 4.0 * share() / (pi_d * pi_d), 1e-5));
  const Mean part = of(scene, SentLight::shaded);
  EXPECT_GT(part.value, 0.1 * 4.0 * share() / (pi_d * pi_d));
}

}  // namespace
}  // namespace occlab::test
