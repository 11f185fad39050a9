#include "harness/metrics/prepared_pair.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "harness/metrics/colour.h"
#include "harness/metrics/image_checks.h"
#include "harness/metrics/parallel.h"
#include "harness/statistics.h"

namespace occlab {
namespace {

Planes planes_of(const Image& image, std::span<const std::size_t> foreground, double scale) {
  Planes planes;
  for (Plane& plane : planes) plane.assign(image.pixel_count(), 0.0f);
  const std::span<const float> values = image.values();
  for (const std::size_t index : foreground) {
    for (std::size_t c = 0; c < 3; ++c) {
      planes[c][index] = static_cast<float>(values[3 * index + c] * scale);
    }
  }
  return planes;
}

Displayed displayed(const PreparedPair& pair, const Planes& radiance, double exposure) {
  Displayed result;
  for (std::size_t c = 0; c < 3; ++c) {
    result.srgb[c].assign(pair.foreground.size(), 0.0f);
    result.lab[c].assign(pair.foreground.size(), 0.0f);
  }
  for_each_row(pair.height, [&](int y) {
    const std::size_t begin = static_cast<std::size_t>(y) * static_cast<std::size_t>(pair.width);
    const std::size_t end = begin + static_cast<std::size_t>(pair.width);
    for (std::size_t i = begin; i < end; ++i) {
      if (pair.foreground[i] == 0.0f) continue;
      Rgb rgb = colour_at(radiance, i);
      for (std::size_t c = 0; c < 3; ++c) {
        rgb[c] = std::clamp(rgb[c] * exposure, 0.0, 1.0);
        result.srgb[c][i] = srgb_encode(static_cast<float>(rgb[c]));
      }
      const Lab lab = xyz_to_lab(rgb_to_xyz(rgb));
      result.lab[0][i] = static_cast<float>(lab.l);
      result.lab[1][i] = static_cast<float>(lab.a);
      result.lab[2][i] = static_cast<float>(lab.b);
    }
  });
  return result;
}

Shadow shadow_of(const PreparedPair& pair, const Image& occlusion,
                 std::span<const std::size_t> foreground) {
  constexpr float open_from = 0.9f;
  constexpr double darkest = 0.01;
  Shadow shadow;
  shadow.member.assign(pair.foreground.size(), 0);
  for (const std::size_t index : foreground) {
    if (!(occlusion.values()[index] < open_from)) continue;
    ++shadow.candidates;
    if (luminance(colour_at(pair.reference, index)) > darkest &&
        luminance(colour_at(pair.test, index)) > darkest) {
      shadow.member[index] = 1;
      ++shadow.members;
    }
  }
  return shadow;
}

LuminanceRange luminance_range(const Planes& planes, std::span<const std::size_t> foreground) {
  std::vector<double> luminances;
  luminances.reserve(foreground.size());
  for (const std::size_t i : foreground) luminances.push_back(luminance(colour_at(planes, i)));
  return {median(luminances), quantile(luminances, 0.99),
          *std::max_element(luminances.begin(), luminances.end())};
}

}  // namespace

std::vector<std::size_t> check_input(const ComparisonInput& input) {
  require_shape(input.reference, "reference", input.reference, 3);
  require_shape(input.test, "test", input.reference, 3);
  require_shape(input.mask, "mask", input.reference, 1);
  std::vector<std::size_t> foreground = foreground_pixels(input.mask);
  require_finite(input.reference, "reference", foreground);
  if (input.reference_occlusion != nullptr) {
    require_shape(*input.reference_occlusion, "reference occlusion", input.reference, 1);
    require_finite(*input.reference_occlusion, "reference occlusion", foreground);
  }
  if (input.reference_variance != nullptr) {
    require_shape(*input.reference_variance, "reference variance", input.reference, 3);
    require_finite_non_negative(*input.reference_variance, "reference variance", foreground);
  }
  return foreground;
}

PreparedPair prepare(const ComparisonInput& input) {
  const std::vector<std::size_t> foreground = check_input(input);
  PreparedPair pair;
  pair.width = input.reference.width();
  pair.height = input.reference.height();
  pair.foreground_count = foreground.size();
  pair.mean_luminance = mean_luminance(input.reference, foreground);
  if (!(pair.mean_luminance > 0.0)) {
    pair.failure = fmt::format(
        "the reference's mean luminance over the foreground is {}, and "
        "errors are relative to it",
        pair.mean_luminance);
    return pair;
  }
  if (const std::size_t bad = count_non_finite(input.test, foreground); bad != 0) {
    pair.failure = fmt::format("{} non-finite pixels in the test image", bad);
    return pair;
  }

  pair.foreground.assign(input.mask.pixel_count(), 0.0f);
  for (const std::size_t index : foreground) pair.foreground[index] = 1.0f;
  const double scale = 1.0 / pair.mean_luminance;
  pair.reference = planes_of(input.reference, foreground, scale);
  pair.test = planes_of(input.test, foreground, scale);
  if (input.reference_variance != nullptr) {
    pair.reference_variance = planes_of(*input.reference_variance, foreground, scale * scale);
  }
  if (input.reference_occlusion != nullptr) {
    pair.shadow = shadow_of(pair, *input.reference_occlusion, foreground);
  }

  pair.reference_luminance = luminance_range(pair.reference, foreground);
  if (const double white = pair.reference_luminance.white; white > 0.0) {
    pair.reference_displayed = displayed(pair, pair.reference, 1.0 / white);
    pair.test_displayed = displayed(pair, pair.test, 1.0 / white);
  }
  return pair;
}

}  // namespace occlab
