// Ray-traced estimates at single surface points, replicated so that their error is known.
//
// Every 4x4 tile of a trace has its own random numbers and its 16 pixels share them. So a point
// gets one lane of many tiles: the tiles are independent replicates of the same estimate.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "harness/statistics.h"
#include "renderers/trace/reference.h"

namespace occlab::test {

struct Point {
  glm::dvec3 position{0.0};
  glm::dvec3 normal{0.0, 0.0, 1.0};
  glm::vec3 albedo{1.0f};
  glm::dvec3 geometric_normal{0.0};  ///< zero: as `normal`
};

/// A mean over independent replicates.
struct Mean {
  double value = 0.0;
  double standard_error = 0.0;
  double degrees = 0.0;
};

inline Mean mean_of(const std::vector<double>& replicates) {
  return {mean(replicates), std::sqrt(variance(replicates) / double(replicates.size())),
          double(replicates.size() - 1)};
}

/// All replicates of one point.
struct PointReplicates {
  std::vector<double> ambient_occlusion;
  std::vector<double> radiance[3];
  std::vector<double> reported_variance[3];
};

/// The test programs of this folder hold fewer than this many comparisons in all; together they
/// raise a false alarm with probability 1e-6 (Sidak 1967).
inline constexpr double family_level = 1e-6;
inline constexpr int family_tests = 1000;

/// Whether a mean is consistent with `expected`, known to within `bias`: Student's t-test, as the
/// error is estimated from the replicates.
inline testing::AssertionResult agrees(const Mean& estimate, double expected, double bias = 1e-6) {
  const double critical =
      -student_quantile(0.5 * sidak_level(family_level, family_tests), estimate.degrees);
  const double error = estimate.value - expected;
  const double accepted = bias + critical * estimate.standard_error;
  if (std::abs(error) <= accepted) return testing::AssertionSuccess();
  return testing::AssertionFailure()
         << "estimate " << estimate.value << ", expected " << expected << ": off by " << error
         << ", accepted " << accepted << " = bias " << bias << " + " << critical << " x "
         << estimate.standard_error;
}

/// Two independent estimates of one value.
inline testing::AssertionResult agree(const Mean& a, const Mean& b) {
  return agrees({a.value - b.value, std::hypot(a.standard_error, b.standard_error), a.degrees},
                0.0);
}

/// At most 16 points, world space, each traced in `tiles` independent tiles.
inline std::vector<PointReplicates> trace_points(const Scene& scene, const Environment& environment,
                                                 const std::vector<Point>& points,
                                                 const TraceSettings& settings, int tiles = 64,
                                                 const std::vector<Light>& lights = {}) {
  EXPECT_LE(points.size(), 16u);
  const int tiles_across = std::min(tiles, 8);
  View view;  // the camera is the identity: view space is world space
  view.width = 4 * tiles_across;
  view.height = 4 * ((tiles + tiles_across - 1) / tiles_across);
  Image position(view.width, view.height, 3), normal = position, geometric = position,
                                              albedo = position;
  Image mask(view.width, view.height, 1);
  const auto lane = [](int x, int y) { return std::size_t((x & 3) + 4 * (y & 3)); };
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      if (lane(x, y) >= points.size()) continue;
      const Point& point = points[lane(x, y)];
      const glm::dvec3 flat =
          point.geometric_normal == glm::dvec3(0.0) ? point.normal : point.geometric_normal;
      for (int c = 0; c < 3; ++c) {
        position.at(x, y, c) = float(point.position[c]);
        normal.at(x, y, c) = float(point.normal[c]);
        geometric.at(x, y, c) = float(flat[c]);
        albedo.at(x, y, c) = point.albedo[c];
      }
      mask.at(x, y) = 1.0f;
    }
  }
  const TracedScene traced(scene);
  const Reference reference = trace_reference(
      traced, environment, lights, view, {position, normal, geometric, albedo, mask}, settings);
  std::vector<PointReplicates> replicates(points.size());
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      if (lane(x, y) >= points.size()) continue;
      PointReplicates& of = replicates[lane(x, y)];
      if (!reference.ambient_occlusion.empty()) {
        of.ambient_occlusion.push_back(double(reference.ambient_occlusion.at(x, y)));
      }
      for (int c = 0; c < 3; ++c) {
        of.radiance[c].push_back(double(reference.radiance.at(x, y, c)));
        of.reported_variance[c].push_back(double(reference.radiance_variance.at(x, y, c)));
      }
    }
  }
  return replicates;
}

/// k_A at the points, by cosine-distributed rays.
inline std::vector<Mean> trace_occlusion(const Scene& scene, const std::vector<Point>& points,
                                         TraceSettings settings = {}) {
  settings.estimator = Estimator::cosine;
  std::vector<Mean> means;
  for (const PointReplicates& of :
       trace_points(scene, constant_environment(glm::vec3(1.0f)), points, settings)) {
    means.push_back(mean_of(of.ambient_occlusion));
  }
  return means;
}

}  // namespace occlab::test
