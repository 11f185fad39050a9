// Metrics that are means over single pixels.
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "harness/metrics/colour.h"
#include "harness/metrics/metric_functions.h"
#include "harness/metrics/parallel.h"

namespace occlab {
namespace {

// Keeps the ratios of relMSE and SMAPE finite where both images are black; a pure number, as
// radiances are relative to the mean luminance.
constexpr double epsilon = 0.01;

Measured unmeasured(std::string reason) { return {std::nullopt, std::move(reason), 0}; }

// The sum of value(index) over all pixels of the image for which `counts` holds.
template <typename Counts, typename Value>
double sum_over(const PreparedPair& pair, Counts&& counts, Value&& value) {
  return sum_over_rows(pair.height, [&](int y) {
    const auto width = static_cast<std::size_t>(pair.width);
    const std::size_t begin = static_cast<std::size_t>(y) * width;
    double sum = 0.0;
    for (std::size_t i = begin; i < begin + width; ++i) {
      if (counts(i)) sum += value(i);
    }
    return sum;
  });
}

// Mean over the foreground and the three channels of value(channel, index).
template <typename Value>
double channel_mean(const PreparedPair& pair, Value&& value) {
  const double sum = sum_over(
      pair, [&](std::size_t i) { return pair.foreground[i] != 0.0f; },
      [&](std::size_t i) { return value(0, i) + value(1, i) + value(2, i); });
  return sum / (3.0 * static_cast<double>(pair.foreground_count));
}

double squared(double x) { return x * x; }

// A mean square less the part that is the reference's own noise.
Measured corrected(const PreparedPair& pair, double total, double of_reference) {
  const double corrected_square = total - of_reference;
  if (!(corrected_square >= 0.0)) {
    return unmeasured(
        fmt::format("the difference is within the reference's own noise (mean square "
                    "{:.3g}, of which the reference's variance is {:.3g})",
                    total, of_reference));
  }
  return {corrected_square, {}, pair.foreground_count};
}

Lab lab_at(const Planes& planes, std::size_t i) {
  return {planes[0][i], planes[1][i], planes[2][i]};
}

// Mean of value(index) over the set S of section "shadow".
template <typename Value>
Measured shadow_mean(const PreparedPair& pair, Value&& value) {
  if (!pair.shadow) return unmeasured("no ambient occlusion of the reference was given");
  if (pair.shadow->members == 0) {
    return unmeasured(
        fmt::format("no pixel is in shadow: {} of {} have a reference ambient "
                    "occlusion below 0.9, none of them bright enough in both images",
                    pair.shadow->candidates, pair.foreground_count));
  }
  const double sum = sum_over(
      pair, [&](std::size_t i) { return pair.shadow->member[i] != 0; }, value);
  return {sum / static_cast<double>(pair.shadow->members), {}, pair.shadow->members};
}

}  // namespace

Measured measure_rmse(const PreparedPair& pair) {
  const double total = channel_mean(pair, [&](std::size_t c, std::size_t i) {
    return squared(double(pair.test[c][i]) - pair.reference[c][i]);
  });
  double of_reference = 0.0;
  if (pair.reference_variance) {
    of_reference = channel_mean(pair, [&](std::size_t c, std::size_t i) {
      return double((*pair.reference_variance)[c][i]);
    });
  }
  Measured result = corrected(pair, total, of_reference);
  if (result.value) result.value = std::sqrt(*result.value);
  return result;
}

Measured measure_relmse(const PreparedPair& pair) {
  const auto weight = [&](std::size_t c, std::size_t i) {
    return 1.0 / (squared(pair.reference[c][i]) + epsilon);
  };
  const double total = channel_mean(pair, [&](std::size_t c, std::size_t i) {
    return squared(double(pair.test[c][i]) - pair.reference[c][i]) * weight(c, i);
  });
  double of_reference = 0.0;
  if (pair.reference_variance) {
    of_reference = channel_mean(pair, [&](std::size_t c, std::size_t i) {
      return (*pair.reference_variance)[c][i] * weight(c, i);
    });
  }
  return corrected(pair, total, of_reference);
}

Measured measure_smape(const PreparedPair& pair) {
  const double value = channel_mean(pair, [&](std::size_t c, std::size_t i) {
    const double x = pair.test[c][i];
    const double r = pair.reference[c][i];
    return std::abs(x - r) / (std::abs(x) + std::abs(r) + epsilon);
  });
  return {value, {}, pair.foreground_count};
}

Measured measure_psnr(const PreparedPair& pair) {
  if (!pair.reference_displayed) return unmeasured(no_exposure);
  const double square = channel_mean(pair, [&](std::size_t c, std::size_t i) {
    return squared(double(pair.test_displayed->srgb[c][i]) - pair.reference_displayed->srgb[c][i]);
  });
  const double value =
      square == 0.0 ? std::numeric_limits<double>::infinity() : -10.0 * std::log10(square);
  return {value, {}, pair.foreground_count};
}

Measured measure_ciede2000(const PreparedPair& pair) {
  if (!pair.reference_displayed) return unmeasured(no_exposure);
  const double sum = sum_over(
      pair, [&](std::size_t i) { return pair.foreground[i] != 0.0f; },
      [&](std::size_t i) {
        return ciede2000(lab_at(pair.reference_displayed->lab, i),
                         lab_at(pair.test_displayed->lab, i));
      });
  return {sum / static_cast<double>(pair.foreground_count), {}, pair.foreground_count};
}

Measured measure_rgb_angle_shadow(const PreparedPair& pair) {
  return shadow_mean(pair, [&](std::size_t i) {
    const Rgb x = colour_at(pair.test, i);
    const Rgb r = colour_at(pair.reference, i);
    // atan2(|x cross r|, x.r) is acos(x.r / |x||r|) that keeps its digits near 0.
    const double cross =
        std::sqrt(squared(x[1] * r[2] - x[2] * r[1]) + squared(x[2] * r[0] - x[0] * r[2]) +
                  squared(x[0] * r[1] - x[1] * r[0]));
    const double dot = x[0] * r[0] + x[1] * r[1] + x[2] * r[2];
    return std::atan2(cross, dot) * 180.0 / std::numbers::pi;
  });
}

Measured measure_delta_uv_shadow(const PreparedPair& pair) {
  if (pair.shadow && pair.shadow->members != 0) {
    // Chromaticity says nothing about colours with negative parts: it may even divide by 0.
    const double negative = sum_over(
        pair, [&](std::size_t i) { return pair.shadow->member[i] != 0; },
        [&](std::size_t i) {
          bool any = false;
          for (std::size_t c = 0; c < 3; ++c) {
            any = any || pair.test[c][i] < 0.0f || pair.reference[c][i] < 0.0f;
          }
          return any ? 1.0 : 0.0;
        });
    if (negative > 0.0) {
      return unmeasured(fmt::format(
          "{} of {} pixels in shadow have a negative channel, whose chromaticity is undefined",
          negative, pair.shadow->members));
    }
  }
  return shadow_mean(pair, [&](std::size_t i) {
    const Chromaticity x = xyz_to_uv(rgb_to_xyz(colour_at(pair.test, i)));
    const Chromaticity r = xyz_to_uv(rgb_to_xyz(colour_at(pair.reference, i)));
    return std::sqrt(squared(x.u - r.u) + squared(x.v - r.v));
  });
}

Measured measure_hue_shadow(const PreparedPair& pair) {
  constexpr double least_chroma = 2.0;
  if (!pair.shadow) return unmeasured("no ambient occlusion of the reference was given");
  if (!pair.reference_displayed) return unmeasured(no_exposure);
  const auto counts = [&](std::size_t i) {
    return pair.shadow->member[i] != 0 &&
           chroma(lab_at(pair.reference_displayed->lab, i)) > least_chroma &&
           chroma(lab_at(pair.test_displayed->lab, i)) > least_chroma;
  };
  const double pixels = sum_over(pair, counts, [](std::size_t) { return 1.0; });
  if (pixels == 0.0) {
    return unmeasured(fmt::format(
        "no pixel is coloured: of {} in shadow none has a chroma above 2 in both images",
        pair.shadow->members));
  }
  const double sum = sum_over(pair, counts, [&](std::size_t i) {
    return hue_difference_degrees(lab_at(pair.reference_displayed->lab, i),
                                  lab_at(pair.test_displayed->lab, i));
  });
  return {sum / pixels, {}, static_cast<std::size_t>(pixels)};
}

Measured measure_shadow_excluded(const PreparedPair& pair) {
  if (!pair.shadow) return unmeasured("no ambient occlusion of the reference was given");
  const std::size_t candidates = pair.shadow->candidates;
  if (candidates == 0) return unmeasured("no pixel has a reference ambient occlusion below 0.9");
  return {1.0 - static_cast<double>(pair.shadow->members) / static_cast<double>(candidates),
          {},
          candidates};
}

}  // namespace occlab
