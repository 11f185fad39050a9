#include "harness/verify/metrics_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "harness/metrics/metrics.h"
#include "harness/verify/sharma_pairs.h"
#include "renderers/scene/image.h"

namespace occlab {
namespace {

/// Floats round L*, a* and b* by some 2e-5 and encoded values by 6e-8.
constexpr double float_bound = 5e-6;
constexpr const char* float_rule = "float rounding, 5e-6, relative above 1";

struct ImagePair {
  Image reference;
  Image test;
};

Check metric_check(const ImagePair& images, std::string name, const std::string& metric,
                   double expected) {
  const Image mask(images.reference.width(), images.reference.height(), 1, 1.0f);
  Check check{.subject = "metrics",
              .name = std::move(name),
              .quantity = metric,
              .measured = std::numeric_limits<double>::quiet_NaN(),
              .expected = expected,
              .bound = float_bound * std::max(1.0, std::abs(expected)),
              .rule = float_rule,
              .detail = ""};
  for (const MetricValue& value : measure({images.reference, images.test, mask})) {
    if (value.name != metric) continue;
    if (value.value) check.measured = *value.value;
    check.detail = value.reason;
  }
  return checked(std::move(check));
}

Image grey(float value) { return {24, 16, 3, value}; }

Image colour(float r, float g, float b) {
  Image image(24, 16, 3);
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    image.values()[3 * i] = r;
    image.values()[3 * i + 1] = g;
    image.values()[3 * i + 2] = b;
  }
  return image;
}

/// Reference 1, test 1/2 everywhere: sRGB 1 and 0.735357, L* 100 and 76.0693.
Checks closed_forms() {
  const ImagePair half = {grey(8.0f), grey(4.0f)};
  const ImagePair black = {grey(8.0f), grey(0.0f)};
  const ImagePair extremes = {colour(0.0f, 1.0f, 0.0f), colour(0.0f, 0.0f, 1.0f)};
  const double encoded = 1.055 * std::pow(0.5, 1.0 / 2.4) - 0.055;
  const std::string name = "constant images, the test of half the radiance";
  return {
      metric_check(half, name, "rmse", 0.5),
      metric_check(half, name, "relmse", 0.25 / 1.01),
      metric_check(half, name, "smape", 0.5 / 1.51),
      metric_check(half, name, "psnr", -20.0 * std::log10(1.0 - encoded)),
      metric_check(half, name, "ssim", (2.0 * encoded + 1e-4) / (1.0 + encoded * encoded + 1e-4)),
      metric_check(black, "white against black", "ciede2000", 100.0),
      metric_check(extremes, "green against blue, the largest difference", "flip_ldr", 1.0),
      metric_check({grey(1.0f), grey(1.0f)}, "equal images", "flip_ldr", 0.0),
      metric_check({grey(1.0f), grey(1.0f)}, "equal images", "flip_hdr", 0.0),
  };
}

Check published_colour_differences() {
  double largest = 0.0;
  std::size_t worst = 0;
  for (std::size_t i = 0; i < sharma_pairs.size(); ++i) {
    const SharmaPair& pair = sharma_pairs[i];
    for (const double difference :
         {ciede2000(pair.first, pair.second), ciede2000(pair.second, pair.first)}) {
      const double error = std::isnan(difference) ? std::numeric_limits<double>::infinity()
                                                  : std::abs(difference - pair.difference);
      if (error <= largest) continue;
      largest = error;
      worst = i;
    }
  }
  return checked({.subject = "metrics",
                  .name = "the 34 published pairs, both orders",
                  .quantity = "largest |ciede2000 - published|",
                  .measured = largest,
                  .expected = 0.0,
                  .bound = 5e-5,
                  .rule = "published with 4 decimals (Sharma et al. 2005)",
                  .detail = fmt::format("largest at pair {}", worst + 1)});
}

/// The integer in [0, 65536) that tests/golden/make_golden.py calls scrambled().
std::uint32_t scrambled(int x, int y, int c, int seed) {
  auto value = static_cast<std::uint32_t>(x) * 7919u + static_cast<std::uint32_t>(y) * 104729u +
               static_cast<std::uint32_t>(c) * 1299709u +
               static_cast<std::uint32_t>(seed) * 15485863u;
  value = (value ^ (value >> 15)) * 2654435761u;
  value = (value ^ (value >> 15)) * 2246822519u;
  return value >> 16;
}

Image golden_noise(int seed) {
  Image image(30, 24, 3);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        image.at(x, y, c) = static_cast<float>(13 + scrambled(x, y, c, seed) % 500) / 256.0f;
      }
    }
  }
  return image;
}

/// The case "noise" of tests/golden/metrics.json: computed by tests/golden/make_golden.py, which
/// shares no code with the metrics.
Checks golden_values() {
  const ImagePair noise = {golden_noise(1), golden_noise(2)};
  Checks checks;
  for (const auto& [metric, expected] :
       std::vector<std::pair<std::string, double>>{{"rmse", 0.774574435840376},
                                                   {"relmse", 5.158028590050618},
                                                   {"smape", 0.354043950703988},
                                                   {"psnr", 10.261520815296944},
                                                   {"ssim", 0.06456714666292865},
                                                   {"flip_ldr", 0.41430038910859235},
                                                   {"flip_hdr", 0.33648772908881613},
                                                   {"ciede2000", 35.34068690328584}}) {
    checks.push_back(
        metric_check(noise, "two images of noise, independently computed", metric, expected));
  }
  return checks;
}

}  // namespace

Checks verify_metrics() {
  Checks checks = closed_forms();
  checks.push_back(published_colour_differences());
  for (Check& check : golden_values()) checks.push_back(std::move(check));
  return checks;
}

}  // namespace occlab
