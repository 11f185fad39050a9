// The ray tracer's ambient occlusion against closed forms. Each case states the bias that its
// tessellation and the lift of the rays' origin allow; beyond that only chance is accepted.
//
// Cosine-weighted occlusion is the area of the blockers' projection onto the tangent plane's unit
// disc, over pi: a wall at distance a blocks, within d_max, the directions whose component u toward
// it is above kappa = a / d_max.

#include <gtest/gtest.h>

#include "tests/analytic/built_scenes.h"
#include "tests/analytic/traced_points.h"

namespace occlab::test {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

/// The plane x = 0 from z = 0 up, facing +X.
Mesh wall(float half_width, float height) {
  return quad({0, -half_width, 0}, {0, 2 * half_width, 0}, {0, 0, height});
}

/// k_A beside an infinite wall.
double wall_occlusion(double kappa) {
  return 1.0 - (std::acos(kappa) - kappa * std::sqrt(1.0 - kappa * kappa)) / pi_d;
}

/// k_A beside an infinite wall whose points at distance d let v(d) through.
double weighted_wall_occlusion(double a, double kappa, const std::function<double(double)>& v) {
  return 1.0 - 2.0 / pi_d * integrate(kappa, 1.0, [&](double u) {
                 return std::sqrt(1.0 - u * u) * (1.0 - v(a / u));
               });
}

TEST(Rays, OpenPlaneIsFullyVisible) {
  const Scene scene = SceneBuilder().add(quad({-3, -3, 0}, {6, 0, 0}, {0, 6, 0})).build();
  for (const float d_max : {1.0f, infinite}) {
    for (const Mean& k : trace_occlusion(scene, {{}, {{1, 1, 0}}}, {.d_max_world = d_max})) {
      EXPECT_EQ(k.value, 1.0);
    }
  }
}

TEST(Rays, RaysBelowTheGeometricSurfaceAreBlockedByIt) {
  // A shading normal at angle t to the plane loses the part of its hemisphere below it.
  const Scene scene = SceneBuilder().add(quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})).build();
  std::vector<Point> points;
  for (const double t : {0.3, 0.8, 1.2}) {
    points.push_back({{0, 0, 0}, {std::sin(t), 0, std::cos(t)}, glm::vec3(1.0f), {0, 0, 1}});
  }
  const auto k = trace_occlusion(scene, points, {.d_max_world = 1.0f});
  // Rays descending by less than the lift within d_max miss: at most lift x 1/pi of the measure.
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_TRUE(agrees(k[i], 0.5 * (1.0 + points[i].normal.z), ray_lift(scene)));
  }
}

TEST(Rays, InfiniteWallWithinReach) {
  const Scene scene = SceneBuilder()
                          .add(quad({0, -1.5f, 0}, {1.5f, 0, 0}, {0, 3, 0}))
                          .add(wall(1.5f, 1.5f))
                          .build();
  const std::vector<double> kappas = {0.002, 0.25, 0.5, 0.75, 0.95, 1.01};
  std::vector<Point> points;
  for (const double kappa : kappas) points.push_back({{kappa, 0, 0}});
  const auto k = trace_occlusion(scene, points, {.rays_per_pixel = 4096, .d_max_world = 1.0f});
  for (std::size_t i = 0; i + 1 < kappas.size(); ++i) {
    EXPECT_TRUE(agrees(k[i], wall_occlusion(kappas[i]))) << "kappa " << kappas[i];
  }
  EXPECT_EQ(k.back().value, 1.0) << "a wall beyond d_max does not count";
  // The literal numbers, so that a slip in wall_occlusion() shows.
  EXPECT_TRUE(agrees(k[0], 0.5, 2.0 * 0.002 / pi_d + 1e-6));
  EXPECT_TRUE(agrees(k[1], 0.657481));
  EXPECT_TRUE(agrees(k[2], 0.804499));
}

TEST(Rays, ThreePlaneCorner) {
  const double kappa = 0.001;
  const Scene scene = SceneBuilder()
                          .add(wall(1.5f, 1.5f))
                          .add(quad({-1.5f, 0, 0}, {3, 0, 0}, {0, 0, 1.5f}))
                          .add(quad({-1.5f, -1.5f, 0}, {3, 0, 0}, {0, 3, 0}))
                          .build();
  const auto k = trace_occlusion(scene, {{{kappa, kappa, 0}}}, {.d_max_world = 1.0f});
  // A quarter, and the strips of width kappa along both walls.
  const double strips = std::asin(kappa) + kappa * std::sqrt(1 - kappa * kappa) + kappa * kappa;
  EXPECT_TRUE(agrees(k[0], 0.25 + strips / pi_d));
}

TEST(Rays, WallOfFiniteHeight) {
  const double w = 20.0;
  for (const double h : {0.5, 1.0, 2.0}) {
    const Scene scene = SceneBuilder().add(wall(float(w), float(h))).build();
    // The form factor of a rectangle that stands on the tangent plane [Howell C-11]; its limit for
    // a wide wall is k = (1 + a/sqrt(a^2 + h^2))/2. Rays start at the lift, so it is that much less
    // high.
    const double seen = h - ray_lift(scene);
    const double slant = std::sqrt(1.0 + seen * seen);
    const double blocked = (std::atan(w) - std::atan(w / slant) / slant) / pi_d;
    const double wide = 0.5 * (1.0 + 1.0 / std::sqrt(1.0 + h * h));
    EXPECT_NEAR(1.0 - blocked, wide, 2e-3);
    const auto k =
        trace_occlusion(scene, {{{1, 0, 0}}}, {.rays_per_pixel = 4096, .d_max_world = infinite});
    EXPECT_TRUE(agrees(k[0], 1.0 - blocked)) << "h " << h;
  }
}

TEST(Rays, LambdaWall) {
  // So large that what is missing of it, seen within 1e-3 rad and lambda D > 300, is below 1e-5.
  const Scene scene = SceneBuilder().add(wall(1000, 1000)).build();
  const std::vector<std::pair<double, double>> cases = {
      {0.3, 0.740403}, {1.0, 0.863380}, {3.0, 0.940624}};
  for (const auto& [K, closed] : cases) {
    const auto v = [lambda = K](double d) { return lambda * d / (1.0 + lambda * d); };
    EXPECT_NEAR(weighted_wall_occlusion(1.0, 0.0, v), closed, 1e-6);
    const auto k = trace_occlusion(scene, {{{1, 0, 0}}},
                                   {.rays_per_pixel = 4096,
                                    .d_max_world = infinite,
                                    .weight = 1,
                                    .lambda_per_world = float(K)});
    EXPECT_TRUE(agrees(k[0], closed, 1e-5)) << "K " << K;
  }
}

TEST(Rays, WeightsWithinReach) {
  const Scene scene = SceneBuilder().add(wall(3, 3)).build();
  const double a = 0.5, d_max = 2.0, start = 0.25;
  const auto lambda = [](double d) { return 3.0 * d / (1.0 + 3.0 * d); };
  const auto fade = [&](double d) {
    const double t = std::clamp((d - start * d_max) / (d_max - start * d_max), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
  };
  TraceSettings settings{.rays_per_pixel = 4096,
                         .d_max_world = float(d_max),
                         .weight = 1,
                         .lambda_per_world = 3.0f,
                         .fade_start = float(start)};
  EXPECT_TRUE(agrees(trace_occlusion(scene, {{{a, 0, 0}}}, settings)[0],
                     weighted_wall_occlusion(a, a / d_max, lambda)));
  settings.weight = 2;
  EXPECT_TRUE(agrees(trace_occlusion(scene, {{{a, 0, 0}}}, settings)[0],
                     weighted_wall_occlusion(a, a / d_max, fade)));
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

TEST(Rays, SphereOnAPlane) {
  const int rings = 128;
  const Scene scene = SceneBuilder().add(sphere_part({0, 0, 1}, 1.0, 0.0, pi_d, rings)).build();
  const std::vector<std::pair<double, double>> cases = {
      {0.5, 0.284458}, {1.0, 0.646447}, {2.0, 0.910557}};
  std::vector<Point> points;
  for (const auto& [r, closed] : cases) points.push_back({{r, 0, 0}});
  const auto k = trace_occlusion(scene, points, {.rays_per_pixel = 4096, .d_max_world = infinite});
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto [r, closed] = cases[i];
    EXPECT_NEAR(1.0 - std::pow(1.0 + r * r, -1.5), closed, 1e-6);
    // From the lifted origin: cos(theta) R^2 / d^2.
    const double height = 1.0 - ray_lift(scene);
    const double blocked = height * std::pow(r * r + height * height, -1.5);
    // The facets lie between the sphere and one that is smaller by this share: of the blocked part,
    // which goes with the square of the radius, at most twice that is missing; half of it either
    // way about the middle.
    const double missing = blocked * 2.0 * (1.0 - sphere_facet_distance(rings));
    EXPECT_TRUE(agrees(k[i], 1.0 - blocked + 0.5 * missing, 0.5 * missing)) << "r " << r;
  }
}

TEST(Rays, SphericalBowlIsTheSameEverywhere) {
  const int rings = 192;
  for (const double opening : {0.5 * pi_d, 0.3 * pi_d}) {
    const Scene scene =
        SceneBuilder().add(sphere_part({0, 0, 0}, 1.0, opening, pi_d, rings)).build();
    // Points inside the facets.
    const double depth = 1.0 - sphere_facet_distance(rings);
    std::vector<Point> points;
    for (const double theta : {1.0, 0.9, 0.75}) {
      const double angle = theta * pi_d;
      const glm::dvec3 out(std::sin(angle), 0.0, std::cos(angle));
      points.push_back({(1.0 - depth) * out, -out});
    }
    const auto k =
        trace_occlusion(scene, points, {.rays_per_pixel = 4096, .d_max_world = infinite});
    for (const Mean& at_point : k) {
      // The opening's radius is exact to 1e-4; a point raised by e sees it larger by less than
      // 4 e in k: dk/de at the bottom is 2 k (cos psi + 1)/(1 + cos psi)^2 sin^2... below 2.
      EXPECT_TRUE(
          agrees(at_point, 0.5 * (1.0 - std::cos(opening)), 4.0 * (depth + ray_lift(scene))));
    }
  }
}

TEST(Rays, ClosedSphere) {
  const int rings = 192;
  const Scene scene = SceneBuilder().add(sphere_part({0, 0, 0}, 1.0, 0.0, pi_d, rings)).build();
  const double depth = 1.0 - sphere_facet_distance(rings);
  const std::vector<Point> points = {{{0, 0, depth - 1.0}, {0, 0, 1}},
                                     {{1.0 - depth, 0, 0}, {-1, 0, 0}}};
  // Distance from the centre of where the rays start; the sphere ends between 1 - depth and 1.
  const double rho = 1.0 - depth - ray_lift(scene);
  // A direction whose cosine to the inward normal is c meets the sphere of radius R after t with
  // R^2 = rho^2 + t^2 - 2 t rho c; nearer than d_max are those of c below this:
  const auto limit = [&](double d_max, double R) {
    return (d_max * d_max + rho * rho - R * R) / (2.0 * d_max * rho);
  };
  for (const double q : {0.25, 0.5, 0.8}) {
    const double smallest = 1.0 - std::pow(limit(2.0 * q, 1.0 - depth), 2.0);
    const double largest = 1.0 - std::pow(limit(2.0 * q, 1.0), 2.0);
    EXPECT_NEAR(0.5 * (smallest + largest), 1.0 - q * q, 2e-3);
    for (const Mean& k :
         trace_occlusion(scene, points, {.rays_per_pixel = 4096, .d_max_world = float(2.0 * q)})) {
      EXPECT_TRUE(agrees(k, 0.5 * (smallest + largest), 0.5 * std::abs(largest - smallest)));
    }
  }
  for (const Mean& k : trace_occlusion(scene, points, {.d_max_world = infinite})) {
    EXPECT_EQ(k.value, 0.0) << "nothing escapes a closed sphere";
  }
  // K = 2 R lambda = 2: k = 1 - 2/K + 2 ln(1 + K)/K^2. Distances are short by at most the depth and
  // lift, or twice that.
  for (const Mean& k : trace_occlusion(
           scene, points, {.rays_per_pixel = 4096, .d_max_world = infinite, .weight = 1})) {
    EXPECT_TRUE(agrees(k, 0.549306, 2.0 * (depth + ray_lift(scene))));
  }
}

TEST(Rays, CylindricalWell) {
  const int segments = 512;
  for (const double h : {1.0, 2.0}) {
    const Scene scene =
        SceneBuilder()
            .add(revolution([h](double t) { return glm::dvec2(1.0, h * t); }, 1, segments))
            .add(revolution([](double t) { return glm::dvec2(t, 0.0); }, 1, segments))
            .build();
    const auto k = trace_occlusion(scene, {{}}, {.rays_per_pixel = 4096, .d_max_world = infinite});
    // sin^2 alpha = 1/(1 + h^2), from the lifted origin; the polygon is smaller by (2 pi/n)^2/6.
    const double seen = h - ray_lift(scene);
    const double disc = 1.0 / (1.0 + seen * seen);
    EXPECT_NEAR(disc, 1.0 / (1.0 + h * h), 1e-3);
    EXPECT_TRUE(agrees(k[0], disc, disc * std::pow(2.0 * pi_d / segments, 2.0)));
  }
}

TEST(Rays, InstancesBlockLikeGeometry) {
  // A mesh that is used twice is instanced, one that is used once is not.
  const Mesh unit = quad({0, -1, 0}, {0, 2, 0}, {0, 0, 1});
  glm::mat4 first(1.0f), second(1.0f);
  first[1][1] = first[2][2] = 1.5f;     // the wall of InfiniteWallWithinReach
  second[3] = glm::vec4(0, 0, -50, 1);  // out of the way
  const Scene once = SceneBuilder().add(unit, first).build();
  const Scene twice = SceneBuilder().add(unit, first).instance(0, second).build();
  const TraceSettings settings{.rays_per_pixel = 4096, .d_max_world = 1.0f};
  EXPECT_TRUE(agrees(trace_occlusion(once, {{{0.25, 0, 0}}}, settings)[0], 0.657481));
  EXPECT_TRUE(agrees(trace_occlusion(twice, {{{0.25, 0, 0}}}, settings)[0], 0.657481));
}

}  // namespace
}  // namespace occlab::test
