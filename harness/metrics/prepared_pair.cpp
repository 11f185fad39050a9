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

double shown(float radiance, double exposure) {
  return std::min(std::max(double(radiance) * exposure, 0.0), 1.0);
}

// Rows of pixels in functions of their own, through plain pointers, so that the loops vectorise.
// They do not ask for the foreground: elsewhere radiance is 0, and black is 0 in both spaces.

void encode_row(float* __restrict encoded, const float* radiance, std::size_t count,
                double exposure) {
  for (std::size_t x = 0; x < count; ++x) {
    encoded[x] = static_cast<float>(srgb_encode(shown(radiance[x], exposure)));
  }
}

void lab_row(float* __restrict l, float* __restrict a, float* __restrict b, const float* red,
             const float* green, const float* blue, std::size_t count, double exposure) {
  for (std::size_t x = 0; x < count; ++x) {
    const Rgb rgb = {shown(red[x], exposure), shown(green[x], exposure), shown(blue[x], exposure)};
    const Lab pixel = xyz_to_lab(rgb_to_xyz(rgb));
    l[x] = static_cast<float>(pixel.l);
    a[x] = static_cast<float>(pixel.a);
    b[x] = static_cast<float>(pixel.b);
  }
}

Displayed displayed(const PreparedPair& pair, const Planes& radiance, double exposure) {
  Displayed result;
  for (Planes* planes : {&result.srgb, &result.lab}) {
    for (Plane& plane : *planes) plane.resize(pair.foreground.size());
  }
  for_each_row(pair.height, [&](int y) {
    const auto width = static_cast<std::size_t>(pair.width);
    for (std::size_t c = 0; c < 3; ++c) {
      encode_row(row_of(result.srgb[c], y, width), row_of(radiance[c], y, width), width, exposure);
    }
    lab_row(row_of(result.lab[0], y, width), row_of(result.lab[1], y, width),
            row_of(result.lab[2], y, width), row_of(radiance[0], y, width),
            row_of(radiance[1], y, width), row_of(radiance[2], y, width), width, exposure);
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
