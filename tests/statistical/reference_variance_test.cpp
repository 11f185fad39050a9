// A 4x4 tile of the reference shares its random numbers, so that its pixels err together. What is
// said of a pixel and of means over pixels holds all the same, shown on the gallery with replicates
// that differ in their seed.
//
// Tiles are independent of each other, which makes them the observations of every test here; tests
// raise a false alarm with probability 1e-6 in all (Sidak 1967).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "harness/metrics/noise_bias.h"
#include "harness/statistics.h"
#include "renderers/scene/data_root.h"
#include "renderers/shared/frame.h"
#include "renderers/trace/reference.h"

namespace occlab {
namespace {

constexpr double false_alarm = 1e-6;
constexpr int tests_of_this_file = 40;
constexpr int replicates = 32;
constexpr float d_max_world = 0.5f;

/// What a camera of the gallery sees, world space, by rays of Embree: a real scene without OpenGL.
class Gallery {
 public:
  static const Gallery& get() {
    static const Gallery gallery;
    return gallery;
  }

  Reference trace(Estimator estimator, long rays, std::uint64_t seed) const {
    return trace_reference(
        traced_, environment_, {}, view_, {position_, normal_, normal_, albedo_, mask_},
        {.rays_per_pixel = rays, .estimator = estimator, .seed = seed, .d_max_world = d_max_world});
  }

  /// The plain way: each pixel on its own, each ray on its own, nothing shared.
  Image trace_independently(long rays, unsigned seed) const {
    Image result(view_.width, view_.height, 3);
    std::mt19937 random(seed);
    const auto uniform = [&] { return float(random() >> 8) * 0x1p-24f; };
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for_surface([&](int x, int y) {
      const glm::vec3 n = at(normal_, x, y);
      const glm::vec3 origin = at(position_, x, y) + traced_.ray_lift_world() * n;
      glm::dvec3 sum(0.0);
      for (long i = 0; i < rays; ++i) {
        const float u = uniform();
        const float angle = 2.0f * pi * uniform();
        const glm::vec3 d =
            tangent_frame(n) * glm::vec3(std::sqrt(u) * std::cos(angle),
                                         std::sqrt(u) * std::sin(angle), std::sqrt(1.0f - u));
        RTCRay ray = ray_of(origin, d, d_max_world);
        rtcOccluded1(traced_.handle(), &context, &ray);
        if (ray.tfar >= 0.0f) sum += glm::dvec3(environment_.radiance(d));
      }
      // rho / pi times pi, with albedo 1.
      for (int c = 0; c < 3; ++c) result.at(x, y, c) = float(sum[c] / double(rays));
    });
    return result;
  }

  /// Calls visit(x, y) for every pixel with a surface.
  void for_surface(const std::function<void(int, int)>& visit) const {
    for (int y = 0; y < view_.height; ++y) {
      for (int x = 0; x < view_.width; ++x) {
        if (mask_.at(x, y) > 0.5f) visit(x, y);
      }
    }
  }

  /// The mean of value(x, y, channel) over each tile's surface; the tiles are independent.
  std::vector<double> tile_means(const std::function<double(int, int, int)>& value) const {
    const auto across = std::size_t((view_.width + 3) / 4);
    std::vector<double> sums(across * std::size_t((view_.height + 3) / 4));
    std::vector<int> counts(sums.size());
    for_surface([&](int x, int y) {
      const std::size_t tile = std::size_t(y / 4) * across + std::size_t(x / 4);
      for (int c = 0; c < 3; ++c) sums[tile] += value(x, y, c) / 3.0;
      ++counts[tile];
    });
    std::vector<double> means;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      if (counts[i] > 0) means.push_back(sums[i] / counts[i]);
    }
    return means;
  }

  const Image& mask() const { return mask_; }

 private:
  Gallery()
      : scene_(load_scene(scene_path("gallery"))),
        traced_(scene_),
        environment_(load_environment({.source = "cathedral", .prefilter_degrees = 8.0f})),
        position_(view_.width, view_.height, 3),
        normal_(view_.width, view_.height, 3),
        albedo_(view_.width, view_.height, 3, 1.0f),
        mask_(view_.width, view_.height, 1) {
    const View camera{scene_.cameras.front(), view_.width, view_.height};
    const glm::vec3 eye(camera.camera.world_from_camera[3]);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (int y = 0; y < view_.height; ++y) {
      for (int x = 0; x < view_.width; ++x) {
        const glm::vec3 film(float(x) + 0.5f - 0.5f * float(view_.width),
                             0.5f * float(view_.height) - float(y) - 0.5f, -camera.focal_pixels());
        const glm::vec3 d = camera.world_from_view_rotation() * normalize(film);
        RTCRayHit hit{};
        hit.ray = ray_of(eye, d, std::numeric_limits<float>::infinity());
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(traced_.handle(), &context, &hit);
        // An instance's normal would have to be transformed; such pixels are left out.
        if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID ||
            hit.hit.instID[0] != RTC_INVALID_GEOMETRY_ID) {
          continue;
        }
        const glm::vec3 flat = normalize(glm::vec3(hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z));
        const glm::vec3 n = dot(flat, d) > 0.0f ? -flat : flat;
        for (int c = 0; c < 3; ++c) {
          position_.at(x, y, c) = eye[c] + hit.ray.tfar * d[c];
          normal_.at(x, y, c) = n[c];
        }
        mask_.at(x, y) = 1.0f;
      }
    }
  }

  static glm::vec3 at(const Image& image, int x, int y) {
    return {image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
  }

  static RTCRay ray_of(glm::vec3 origin, glm::vec3 d, float reach) {
    RTCRay ray{};
    ray.org_x = origin.x;
    ray.org_y = origin.y;
    ray.org_z = origin.z;
    ray.dir_x = d.x;
    ray.dir_y = d.y;
    ray.dir_z = d.z;
    ray.tfar = reach;
    ray.mask = ~0u;
    return ray;
  }

  View view_{.camera = {}, .width = 96, .height = 54};  // the identity: view space is world space
  Scene scene_;
  TracedScene traced_;
  Environment environment_;
  Image position_, normal_, albedo_, mask_;
};

/// Whether the mean of independent observations is `expected`, to within `bias`: Student's t-test.
testing::AssertionResult mean_is(const std::vector<double>& observations, double expected,
                                 double bias = 0.0) {
  const auto n = double(observations.size());
  const double error = mean(observations) - expected;
  const double critical =
      -student_quantile(0.5 * sidak_level(false_alarm, tests_of_this_file), n - 1.0);
  const double accepted = bias + critical * std::sqrt(variance(observations) / n);
  if (std::fabs(error) <= accepted) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "mean " << mean(observations) << ", expected " << expected
                                     << ", accepted +- " << accepted;
}

constexpr Estimator estimators[] = {Estimator::mis, Estimator::cosine, Estimator::environment};

std::vector<Reference> many(Estimator estimator, long rays) {
  std::vector<Reference> references;
  for (int r = 0; r < replicates; ++r) {
    references.push_back(Gallery::get().trace(estimator, rays, 100 + std::uint64_t(r)));
  }
  return references;
}

TEST(ReferenceVariance, OfAPixelIsThatOfItsReplicates) {
  const Gallery& gallery = Gallery::get();
  for (const Estimator estimator : estimators) {
    // From one or two rays a batch to some that are stratified among themselves.
    for (const long rays : {32L, 256L}) {
      const std::vector<Reference> references = many(estimator, rays);
      double reported_sum = 0.0;
      const auto observed_less_reported = [&](int x, int y, int c) {
        std::vector<double> values;
        double reported = 0.0;
        for (const Reference& reference : references) {
          values.push_back(double(reference.radiance.at(x, y, c)));
          reported += double(reference.radiance_variance.at(x, y, c)) / replicates;
        }
        reported_sum += reported;
        return variance(values) - reported;
      };
      const std::vector<double> differences = gallery.tile_means(observed_less_reported);
      EXPECT_TRUE(mean_is(differences, 0.0)) << int(estimator) << ", rays " << rays;
      // The test would tell 5%: its interval is not wider than that.
      const double typical = reported_sum / (3.0 * 16.0 * double(differences.size()));
      EXPECT_LT(std::sqrt(variance(differences) / double(differences.size())), 0.02 * typical);
    }
  }
}

TEST(ReferenceVariance, ErrorsAreMeasuredWithoutBias) {
  // A test image that is wrong by a tenth and noisy. Whatever reference judges it: on average over
  // the references rmse^2, bias^2 and mse are what an almost noise-free reference says.
  const Gallery& gallery = Gallery::get();
  const auto wrong = [&](std::uint64_t seed) {
    Image image = gallery.trace(Estimator::mis, 64, seed).radiance;
    for (float& value : image.values()) value *= 1.1f;
    return image;
  };
  RunStatistics runs(gallery.mask());
  for (std::uint64_t seed = 1; seed <= 4; ++seed) runs.add(wrong(seed));
  const auto judge = [&](const Reference& reference) {
    const NoiseBias found = noise_and_bias(runs, reference.radiance, &reference.radiance_variance);
    // In radiance, so that the reference's mean luminance, noisy too, has no part in it.
    const double unit = found.mean_luminance * found.mean_luminance;
    return std::array<double, 3>{*found.bias_squared.value * unit, *found.mse.value * unit,
                                 found.bias_squared_reference_error * unit};
  };
  const std::array<double, 3> exact = judge(gallery.trace(Estimator::mis, 16384, 7));
  std::vector<double> bias_squared;
  std::vector<double> mse;
  std::vector<double> stated_error;
  for (const Reference& reference : many(Estimator::mis, 64)) {
    const std::array<double, 3> found = judge(reference);
    bias_squared.push_back(found[0]);
    mse.push_back(found[1]);
    stated_error.push_back(found[2]);
  }
  EXPECT_GT(exact[0], 10.0 * exact[2]) << "there is a bias to measure";
  // The reference that stands for the truth has its own error.
  EXPECT_TRUE(mean_is(bias_squared, exact[0], 4.0 * exact[2]));
  EXPECT_TRUE(mean_is(mse, exact[1], 4.0 * exact[2]));
  // The error that is stated for one reference holds what the references really scatter by. The
  // ratio of the two variances would exceed chi2_31 / 31 = 2.6 with probability 4e-6.
  const double scatter = std::sqrt(variance(bias_squared));
  EXPECT_LT(scatter, std::sqrt(2.6) * mean(stated_error));
  EXPECT_GT(4.0 * scatter, mean(stated_error)) << "on the safe side, but not by much";
}

TEST(ReferenceVariance, TilesChangeNothingAgainstPlainRays) {
  const Gallery& gallery = Gallery::get();
  const Image plain = gallery.trace_independently(4096, 3);
  for (const Estimator estimator : estimators) {
    const Reference tiled = gallery.trace(estimator, 4096, 11);
    EXPECT_TRUE(mean_is(gallery.tile_means([&](int x, int y, int c) {
      return double(tiled.radiance.at(x, y, c)) - double(plain.at(x, y, c));
    }),
                        0.0))
        << int(estimator);
  }
}

TEST(ReferenceVariance, EstimatorsAgreeWithinThreeSigma) {
  const Gallery& gallery = Gallery::get();
  std::vector<Reference> references;
  for (const Estimator estimator : estimators) {
    references.push_back(gallery.trace(estimator, 1024, 21 + std::uint64_t(estimator)));
  }
  for (const auto& [a, b] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}}) {
    const Reference& first = references[std::size_t(a)];
    const Reference& second = references[std::size_t(b)];
    const auto difference = [&](int x, int y, int c) {
      return double(first.radiance.at(x, y, c)) - double(second.radiance.at(x, y, c));
    };
    EXPECT_TRUE(mean_is(gallery.tile_means(difference), 0.0)) << a << " " << b;
    const std::vector<double> beyond = gallery.tile_means([&](int x, int y, int c) {
      const double sigma = std::sqrt(double(first.radiance_variance.at(x, y, c)) +
                                     double(second.radiance_variance.at(x, y, c)));
      return std::fabs(difference(x, y, c)) > 3.0 * sigma ? 1.0 : 0.0;
    });
    // Both sigmas come from 16 batches: 0.5% (30 degrees of freedom) to 0.9% (15) are beyond 3.
    EXPECT_LT(mean(beyond), 0.02) << a << " " << b;
  }
}

}  // namespace
}  // namespace occlab
