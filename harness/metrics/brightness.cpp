#include "harness/metrics/brightness.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "harness/metrics/image_checks.h"
#include "renderers/scene/error.h"

namespace occlab {

const std::vector<BrightnessInfo>& brightness_metrics() {
  static const std::vector<BrightnessInfo> all = {
      {"mean_red", "mean of the picture's red, linear radiance"},
      {"mean_green", "mean of the picture's green, linear radiance"},
      {"mean_blue", "mean of the picture's blue, linear radiance"},
      {"mean_luminance", "mean of the picture's Rec.709 luminance, linear radiance"}};
  return all;
}

bool is_brightness_metric(std::string_view name) {
  const std::vector<BrightnessInfo>& all = brightness_metrics();
  return std::ranges::find(all, name, &BrightnessInfo::name) != all.end();
}

std::vector<MetricValue> measure_brightness(const Image& test, const Image& mask) {
  require_shape(mask, "mask", test, 1);
  require_shape(test, "test", test, 3);
  std::array<double, 3> sums{};
  std::size_t pixels = 0;
  std::size_t not_finite = 0;
  for (std::size_t p = 0; p < mask.pixel_count(); ++p) {
    if (!(mask.values()[p] > 0.5f)) continue;
    ++pixels;
    const auto rgb = test.values().subspan(3 * p, 3);
    if (!std::ranges::all_of(rgb, [](float value) { return std::isfinite(value); })) {
      ++not_finite;
      continue;
    }
    for (std::size_t c = 0; c < 3; ++c) sums[c] += double(rgb[c]);
  }
  if (pixels == 0) throw InputError("the mask is empty: there is nothing to measure");
  const double n = double(pixels);
  const std::array<double, 4> values = {
      sums[0] / n, sums[1] / n, sums[2] / n,
      (0.2126 * sums[0] + 0.7152 * sums[1] + 0.0722 * sums[2]) / n};
  std::vector<MetricValue> all;
  for (std::size_t i = 0; i < values.size(); ++i) {
    MetricValue metric;
    metric.name = brightness_metrics()[i].name;
    metric.unit = "radiance";
    metric.pixels = pixels;
    if (not_finite > 0) {
      metric.reason = fmt::format("{} pixels are not finite", not_finite);
    } else {
      metric.value = values[i];
    }
    all.push_back(std::move(metric));
  }
  return all;
}

}  // namespace occlab
