#include "harness/metrics/metrics.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <span>

#include "harness/metrics/colour.h"
#include "harness/metrics/image_checks.h"
#include "harness/metrics/metric_functions.h"
#include "harness/metrics/prepared_pair.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

template <int sigma>
Measured measure_high_frequency_residual(const PreparedPair& pair) {
  return high_frequency_residual(pair, sigma);
}

// Every value is a finite number but for the one that is infinite by definition.
void refuse_non_finite(Measured& measured, bool may_be_infinite) {
  if (!measured.value || std::isfinite(*measured.value)) return;
  if (may_be_infinite && *measured.value == std::numeric_limits<double>::infinity()) return;
  measured.reason = fmt::format("the result overflowed to {}", *measured.value);
  measured.value.reset();
}

}  // namespace

const std::vector<MetricInfo>& metrics() {
  constexpr bool lower = true;
  constexpr bool higher = false;
  constexpr const char* relative = "mean luminance";
  static const std::vector<MetricInfo> list = {
      {"rmse", relative,
       "Root of the mean over foreground and channels of (x - r)^2, radiances relative to the "
       "reference's mean luminance; the mean of the reference's variance, where known, is "
       "subtracted before the root.",
       lower, measure_rmse},
      {"relmse", "1",
       "Mean of (x - r)^2 / (r^2 + 0.01), radiances relative to the reference's mean luminance; "
       "the mean of the reference's variance / (r^2 + 0.01), where known, is subtracted.",
       lower, measure_relmse},
      {"smape", "1",
       "Mean of |x - r| / (|x| + |r| + 0.01), radiances relative to the reference's mean "
       "luminance; "
       "includes the reference's own noise.",
       lower, measure_smape},
      {"psnr", "dB",
       "-10 log10 of the mean square difference of sRGB values, after one exposure for both that "
       "takes the reference's 99th-percentile luminance to 1, and a clamp to [0, 1]; infinite for "
       "equal images.",
       higher, measure_psnr},
      {"ssim", "1",
       "Mean structural similarity of the sRGB luma of the psnr images: 11 x 11 Gaussian windows "
       "(sigma 1.5) that lie wholly in the foreground, K = 0.01, 0.03, L = 1 (Wang et al. 2004).",
       higher, measure_ssim},
      {"flip_ldr", "1",
       "Mean FLIP difference of the exposed, clamped images of psnr, 0 to 1, for 67 pixels per "
       "degree; where the mask is 0 both images are the same grey (Andersson et al. 2020).",
       lower, measure_flip_ldr},
      {"flip_hdr", "1",
       "Mean over pixels of the largest FLIP difference over the exposures that take the "
       "reference's luminances between its maximum and its median to 0.85 of the display, through "
       "the ACES tone curve (Andersson et al. 2021).",
       lower, measure_flip_hdr},
      {"ciede2000", "dE00",
       "Mean CIEDE2000 difference of the exposed, clamped colours of psnr, in CIELAB under D65.",
       lower, measure_ciede2000},
      {"rgb_angle_shadow", "degree",
       "Mean angle between the linear RGB vectors x and r in shadow: where the reference's ambient "
       "occlusion is below 0.9 and both luminances exceed 1% of the reference's mean.",
       lower, measure_rgb_angle_shadow},
      {"delta_uv_shadow", "1", "Mean distance of the CIE 1976 u'v' chromaticities in shadow.",
       lower, measure_delta_uv_shadow},
      {"hue_shadow", "degree",
       "Mean absolute CIELAB hue difference in shadow where the chroma C* of both exposed, clamped "
       "colours exceeds 2.",
       lower, measure_hue_shadow},
      {"shadow_excluded", "1",
       "Share of the pixels with a reference ambient occlusion below 0.9 that the shadow metrics "
       "leave out because one of the images is too dark there.",
       lower, measure_shadow_excluded},
      {"high_frequency_residual_2", relative,
       "Root mean square of e - G e, e = x - r relative to the reference's mean luminance, G a "
       "mask-normalised Gaussian of sigma 2 pixels, cut at 4 sigma.",
       lower, measure_high_frequency_residual<2>},
      {"high_frequency_residual_4", relative, "The same with a Gaussian of sigma 4 pixels.", lower,
       measure_high_frequency_residual<4>},
  };
  return list;
}

std::vector<MetricValue> measure(const ComparisonInput& input) {
  const PreparedPair pair = prepare(input);
  std::vector<MetricValue> values;
  for (const MetricInfo& info : metrics()) {
    Measured measured;
    if (pair.failure.empty()) {
      measured = info.measure(pair);
      refuse_non_finite(measured, info.measure == measure_psnr);
    } else {
      measured.reason = pair.failure;
    }
    values.push_back({std::move(measured), info.name, info.unit});
  }
  return values;
}

Image error_map(const ComparisonInput& input, ErrorMap kind) {
  const std::vector<std::size_t> foreground = check_input(input);
  const double mean = mean_luminance(input.reference, foreground);
  if (!(mean > 0.0)) {
    throw InputError(
        fmt::format("reference image: its mean luminance over the foreground is {}; "
                    "accepted: above 0, as errors are relative to it",
                    mean));
  }
  Image map(input.reference.width(), input.reference.height(), 1);
  for (const std::size_t index : foreground) {
    const std::span<const float> x = input.test.values().subspan(3 * index, 3);
    const std::span<const float> r = input.reference.values().subspan(3 * index, 3);
    const Rgb e = {double(x[0]) - r[0], double(x[1]) - r[1], double(x[2]) - r[2]};
    const double error = kind == ErrorMap::signed_luminance
                             ? luminance(e)
                             : std::sqrt((e[0] * e[0] + e[1] * e[1] + e[2] * e[2]) / 3.0);
    // An infinite test pixel is as unmeasurable as a NaN.
    map.values()[index] = std::isfinite(error) ? static_cast<float>(error / mean) : std::nanf("");
  }
  return map;
}

}  // namespace occlab
