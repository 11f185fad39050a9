// A floor before a wall, where the march's expectation is known.
//
// With jittered steps and a wall that is solid behind its surface, a direction with component u
// toward the wall is found blocked with probability clamp((1 - kappa/u) S, 0, 1), kappa = a/d_max
// for the distance a of the wall. The camera looks along the wall's normal, a little downwards, so
// that each row of the image lies at one distance and every sample behind the wall projects onto
// the wall's visible face.

#include <gtest/gtest.h>

#include "renderers/shared/representation_sh4.h"
#include "tests/analytic/traced_points.h"
#include "tests/gpu/gpu_frame.h"

namespace occlab::test {
namespace {

constexpr double d_max = 1.0;
// 15 degrees downwards; the floor before the wall fills the image's lower half.
const View toward_wall = look_at({8, 3.2f, 0}, {0, 1.0f, 0}, 0.35f, 160, 144);
constexpr int first_column = 56, last_column = 104;  // no sample leaves the image sideways

Values settings(long samples, long steps, long seed) {
  return {{"samples", samples}, {"steps", steps},     {"seed", seed},
          {"filter", "none"},   {"bias_world", 1e-4}, {"epsilon_world", 1e-4}};
}

double detection(double kappa, double u, int steps) {
  return u <= kappa ? 0.0 : std::min(1.0, (1.0 - kappa / u) * steps);
}

/// The integral over the hemisphere of f(w) (1 - detection), w in the frame (x: away from the wall,
/// y: along it, z: up); midpoint rule in height and azimuth.
glm::dvec3 visible_integral(double kappa, int steps,
                            const std::function<glm::dvec3(glm::dvec3)>& f) {
  constexpr int heights = 200, azimuths = 400;
  glm::dvec3 sum(0.0);
  for (int i = 0; i < heights; ++i) {
    const double z = (i + 0.5) / heights, r = std::sqrt(1.0 - z * z);
    for (int j = 0; j < azimuths; ++j) {
      const double phi = 2.0 * pi_d * (j + 0.5) / azimuths;
      const glm::dvec3 w(r * std::cos(phi), r * std::sin(phi), z);
      sum += (1.0 - detection(kappa, -w.x, steps)) * f(w);
    }
  }
  return sum * 2.0 * pi_d / double(heights * azimuths);
}

/// The rows whose floor points are at distances in [low, high] from the wall.
struct Row {
  int y;
  double kappa;
  double pixel_world;  ///< how much distance one pixel is there
};
std::vector<Row> rows_between(const TestFrame& frame, double low, double high) {
  const glm::mat4 world_from_view = frame.frame().view.camera.world_from_camera;
  const auto world = [&](int x, int y) {
    const glm::dvec3 p = pixel3(frame.surface().position_view, x, y);
    return glm::dvec3(world_from_view * glm::vec4(glm::vec3(p), 1.0f));
  };
  std::vector<Row> rows;
  for (int y = 0; y < frame.height(); ++y) {
    const glm::dvec3 p = world(frame.width() / 2, y);
    if (std::abs(p.y) > 1e-4 || p.x < low || p.x > high) continue;
    EXPECT_NEAR(world(first_column, y).x, p.x, 1e-4) << "a row lies at one distance";
    rows.push_back({y, p.x / d_max, glm::length(world(frame.width() / 2 + 1, y) - p)});
  }
  EXPECT_GE(rows.size(), 2u);
  return rows;
}

/// What each channel of a layer should be at kappa.
using Expectation = std::function<std::vector<double>(double kappa)>;

/// Over seeds, the mean over rows and columns of each channel less its expectation there.
std::vector<Mean> residuals(const TestFrame& frame, const std::vector<Row>& rows,
                            const std::string& method, const std::string& layer, long steps,
                            const Expectation& expected, const Values& more = {}) {
  constexpr long seeds = 24;
  std::vector<double> expected_mean;
  for (const Row& row : rows) {
    const std::vector<double> values = expected(row.kappa);
    expected_mean.resize(values.size());
    for (std::size_t c = 0; c < values.size(); ++c) {
      expected_mean[c] += values[c] / double(rows.size());
    }
  }
  std::vector<std::vector<double>> found(expected_mean.size());
  for (long seed = 1; seed <= seeds; ++seed) {
    Values values = settings(64, steps, seed);
    values.insert(values.end(), more.begin(), more.end());
    const Image image = frame.layer(method, layer, values);
    EXPECT_EQ(std::size_t(image.channels()), found.size());
    for (std::size_t c = 0; c < found.size(); ++c) {
      double sum = 0.0;
      for (const Row& row : rows) {
        for (int x = first_column; x < last_column; ++x) sum += double(image.at(x, row.y, int(c)));
      }
      const double pixels = double(rows.size()) * (last_column - first_column);
      found[c].push_back(sum / pixels - expected_mean[c]);
    }
  }
  std::vector<Mean> means;
  for (const auto& of : found) means.push_back(mean_of(of));
  return means;
}

/// What the nearest pixel, taken for the point itself, may do to a quantity whose slope in kappa is
/// at most `slope`. It errs by up to half a pixel to either side, which cancels but for a tenth of
/// a pixel (measured: less).
double pixel_bound(const std::vector<Row>& rows, double slope) {
  return slope * 0.1 * rows.front().pixel_world / d_max;
}

class Wall : public testing::Test {
 protected:
  static const TestFrame& uniform() {
    static const TestFrame frame(floor_and_tall_wall(), toward_wall,
                                 constant_environment(glm::vec3(1.0f)));
    return frame;
  }
};

TEST_F(Wall, ClosedFormsOfTheMarch) {
  // The expectation integrated here against its closed form for S = 1 and the tabulated values.
  const auto k = [](double kappa, int steps) {
    return visible_integral(kappa, steps, [](glm::dvec3 w) { return glm::dvec3(w.z); }).x / pi_d;
  };
  for (const double kappa : {0.25, 0.5}) {
    const double one = 1.0 - (std::acos(kappa) + kappa * std::sqrt(1 - kappa * kappa) -
                              2 * kappa * std::acosh(1 / kappa)) /
                                 pi_d;
    EXPECT_NEAR(k(kappa, 1), one, 1e-5);
  }
  EXPECT_NEAR(k(0.25, 1), 0.831786, 1e-5);
  EXPECT_NEAR(k(0.5, 1), 0.948035, 1e-5);
  EXPECT_NEAR(k(0.25, 2), 0.715537, 1e-5);
  EXPECT_NEAR(k(0.5, 2), 0.896070, 1e-5);
  EXPECT_NEAR(k(0.25, 4), 0.680531, 1e-5);
  EXPECT_NEAR(k(0.5, 4), 0.844415, 1e-5);
}

TEST_F(Wall, AmbientOcclusionHasTheExpectedMarchBias) {
  for (const double kappa : {0.05, 0.25, 0.5}) {
    const auto rows = rows_between(uniform(), kappa - 0.05, kappa + 0.05);
    for (const int steps : {1, 2, 4}) {
      const auto k_A = [&](double at) -> std::vector<double> {
        return {visible_integral(at, steps, [](glm::dvec3 w) { return glm::dvec3(w.z); }).x / pi_d};
      };
      const auto uniform_share = [&](double at) -> std::vector<double> {
        return {visible_integral(at, steps, [](glm::dvec3) { return glm::dvec3(1); }).x /
                (2 * pi_d)};
      };
      // dk/dkappa is at most 2/pi for one step, and less than twice that for more.
      const double bias = pixel_bound(rows, 2.0 / pi_d * std::min(steps, 2));
      EXPECT_TRUE(
          agrees(residuals(uniform(), rows, "ssao", "ambient_occlusion", steps, k_A)[0], 0.0, bias))
          << "SSAO kappa " << kappa << " S " << steps;
      EXPECT_TRUE(
          agrees(residuals(uniform(), rows, "ssbn", "uniform_occlusion", steps, uniform_share)[0],
                 0.0, bias))
          << "SSBN kappa " << kappa << " S " << steps;
    }
  }
}

TEST_F(Wall, LightOfALinearSky) {
  // L = 1 - x/2 + z/2 and so on, of which order-4 harmonics keep everything.
  const auto L = [](glm::dvec3 w) {
    return glm::dvec3(1 - 0.5 * w.x + 0.5 * w.z, 1 + 0.7 * w.y, 1 + 0.9 * w.x);
  };
  // World: x as it is, y up is the frame's z, the frame's y is the world's -z.
  const TestFrame frame(floor_and_tall_wall(), toward_wall, probe_of(256, [&](glm::vec3 d) {
                          return glm::vec3(L(glm::dvec3(d.x, -d.z, d.y)));
                        }));
  const auto rows = rows_between(frame, 0.2, 0.4);
  for (const int steps : {1, 2}) {
    const auto irradiance = [&](double at) -> std::vector<double> {
      const glm::dvec3 E = visible_integral(at, steps, [&](glm::dvec3 w) { return w.z * L(w); });
      return {E.x, E.y, E.z};
    };
    const auto radiance = [&](double at) {
      std::vector<double> values = irradiance(at);
      for (double& value : values) value /= pi_d;
      return values;
    };
    const double bias = pixel_bound(rows, 2.0 * 1.7 * steps) + 2e-3;
    const auto ssdo = residuals(frame, rows, "ssdo", "irradiance", steps, irradiance);
    const auto s3ho = residuals(frame, rows, "s3ho", "radiance", steps, radiance);
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_TRUE(agrees(ssdo[c], 0.0, bias)) << "SSDO " << c << " S " << steps;
      EXPECT_TRUE(agrees(s3ho[c], 0.0, bias / pi_d)) << "S3HO " << c << " S " << steps;
    }
  }
}

TEST_F(Wall, SphericalHarmonicsOfTheVisibleCosine) {
  // Each coefficient is the integral of its basis function: order, signs and packing.
  const auto rows = rows_between(uniform(), 0.2, 0.3);
  const glm::mat3 view_from_world(uniform().frame().view.view_from_world());
  const auto in_view = [&](glm::dvec3 w) {
    return view_from_world * glm::vec3(float(w.x), float(w.z), float(-w.y));
  };
  const auto coefficients = [&](double at) {
    std::vector<double> values;
    for (int i = 0; i < 16; ++i) {
      values.push_back(visible_integral(at, 2, [&](glm::dvec3 w) {
                         const Sh4 y = sh_basis(in_view(w));
                         const glm::vec4 quarters[4] = {y.c0, y.c1, y.c2, y.c3};
                         return glm::dvec3(double(quarters[i / 4][i % 4]) * w.z);
                       }).x);
    }
    return values;
  };
  const auto means = residuals(uniform(), rows, "s3ho", "sh_visibility", 2, coefficients);
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_TRUE(agrees(means[i], 0.0, pixel_bound(rows, 4.0) + 1e-3)) << "coefficient " << i;
  }
}

TEST_F(Wall, BentNormalLeansAway) {
  const auto rows = rows_between(uniform(), 0.2, 0.3);
  const glm::mat3 view_from_world(uniform().frame().view.view_from_world());
  const auto bent = [&](double at) -> std::vector<double> {
    const glm::dvec3 sum = visible_integral(at, 2, [](glm::dvec3 w) { return w; });
    const double open = visible_integral(at, 2, [](glm::dvec3) { return glm::dvec3(1); }).x;
    const glm::vec3 in_view = view_from_world * glm::vec3(sum.x, sum.z, -sum.y);
    return {in_view.x / open, in_view.y / open, in_view.z / open};
  };
  const auto means = residuals(uniform(), rows, "ssbn", "bent_normal", 2, bent);
  for (std::size_t c = 0; c < 3; ++c) {
    // A ratio of two sums of 64 samples has a bias of the order of 1/64 of its variance.
    EXPECT_TRUE(agrees(means[c], 0.0, pixel_bound(rows, 1.0) + 2e-3)) << c;
  }
}

/// The march of one pixel against the wall and the floor as planes instead of pixels: what the pass
/// would find at infinite resolution, averaged over directions and offsets.
double march_expectation(const View& view, double a, int steps,
                         const std::function<double(double)>& weight) {
  const glm::dvec3 eye(glm::vec3(view.camera.world_from_camera[3]));
  const glm::dvec3 p(a, 0.0, 0.0);
  constexpr int heights = 64, azimuths = 128, offsets = 64;
  double sum = 0.0;
  for (int i = 0; i < heights; ++i) {
    const double h = (i + 0.5) / heights, r = std::sqrt(1.0 - h * h);
    for (int j = 0; j < azimuths; ++j) {
      const double phi = 2.0 * pi_d * (j + 0.5) / azimuths;
      const glm::dvec3 s(r * std::cos(phi), h, r * std::sin(phi));
      for (int o = 0; o < offsets; ++o) {
        double v = 1.0;
        for (int k = 0; k < steps && v == 1.0; ++k) {
          const glm::dvec3 q = p + s * (d_max * (k + (o + 0.5) / offsets) / steps);
          if (q.x >= 0.0) continue;
          const glm::dvec3 seen = q + (eye - q) * (-q.x / (eye.x - q.x));
          const double d = glm::length(seen - p);
          if (d <= d_max) v = weight(d);
        }
        sum += v * h;
      }
    }
  }
  return 2.0 * sum / (heights * azimuths * offsets);
}

TEST_F(Wall, WeightsOfTheBlockersDistance) {
  const auto rows = rows_between(uniform(), 0.2, 0.4);
  const auto lambda = [](double d) { return 2.5 * d / (1.0 + 2.5 * d); };
  const auto fade = [](double d) {
    const double t = std::clamp((d - 0.3) / 0.7, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
  };
  for (const int steps : {1, 3}) {
    const double bias = pixel_bound(rows, 2.0 * std::min(steps, 2));
    const auto with = [&](const std::function<double(double)>& weight) {
      return [&, weight](double at) -> std::vector<double> {
        return {march_expectation(toward_wall, at * d_max, steps, weight)};
      };
    };
    EXPECT_TRUE(agrees(residuals(uniform(), rows, "ssao", "ambient_occlusion", steps, with(lambda),
                                 {{"weight", "lambda"}, {"lambda_per_world", 2.5}})[0],
                       0.0, bias))
        << "lambda, S " << steps;
    EXPECT_TRUE(agrees(residuals(uniform(), rows, "ssao", "ambient_occlusion", steps, with(fade),
                                 {{"weight", "smoothstep"}, {"fade_start", 0.3}})[0],
                       0.0, bias))
        << "smoothstep, S " << steps;
    EXPECT_TRUE(agrees(residuals(uniform(), rows, "ssao", "ambient_occlusion", steps,
                                 with([](double) { return 0.0; }))[0],
                       0.0, bias))
        << "binary, S " << steps;
  }
}

TEST_F(Wall, OcclusionOfS3hoIsThatOfSsao) {
  // k_A = (2/sqrt(pi)) c_0, sample by sample: the same directions, offsets and weights.
  for (const char* weight : {"binary", "lambda", "smoothstep"}) {
    Values values = settings(32, 2, 3);
    values.emplace_back("weight", weight);
    const Layers ssao = uniform().evaluate("ssao", values);
    const Layers s3ho = uniform().evaluate("s3ho", values);
    const Layers ssdo = uniform().evaluate("ssdo", values);
    int differing = 0;
    for (int y = 0; y < uniform().height(); ++y) {
      for (int x = 0; x < uniform().width(); ++x) {
        const float k = ssao.at("ambient_occlusion").at(x, y);
        // A last bit of a half float each.
        differing += std::abs(s3ho.at("ambient_occlusion").at(x, y) - k) > 0x1p-10f * k ? 1 : 0;
        differing += std::abs(s3ho.at("radiance").at(x, y) - k) > 0x1p-9f * k ? 1 : 0;
        differing += std::abs(ssao.at("radiance").at(x, y) - k) > 1e-3f * k ? 1 : 0;
        differing += std::abs(ssdo.at("radiance").at(x, y) - k) > 1e-3f * k ? 1 : 0;
      }
    }
    EXPECT_EQ(differing, 0) << weight << ": all see the same sky through the same openings";
  }
}

}  // namespace
}  // namespace occlab::test
