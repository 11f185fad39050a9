// LDR-FLIP and HDR-FLIP as metrics.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "harness/metrics/flip_map.h"
#include "harness/metrics/metric_functions.h"
#include "harness/metrics/parallel.h"

namespace occlab {
namespace {

Measured mean_over_foreground(const PreparedPair& pair, const Plane& map) {
  const double sum = sum_over_rows(pair.height, [&](int row) {
    const auto width = static_cast<std::size_t>(pair.width);
    const std::size_t begin = static_cast<std::size_t>(row) * width;
    double of_row = 0.0;
    for (std::size_t i = begin; i < begin + width; ++i) {
      of_row += double(pair.foreground[i]) * double(map[i]);
    }
    return of_row;
  });
  return {sum / static_cast<double>(pair.foreground_count), {}, pair.foreground_count};
}

Plane map_at(const PreparedPair& pair, const FlipDisplay& display) {
  return flip_map(flip_image(pair, pair.reference, display), flip_image(pair, pair.test, display));
}

void raise_to(Plane& largest, const Plane& map) {
  for (std::size_t i = 0; i < map.size(); ++i) largest[i] = std::max(largest[i], map[i]);
}

}  // namespace

Measured measure_flip_ldr(const PreparedPair& pair) {
  const double white = pair.reference_luminance.white;
  if (!(white > 0.0)) return {std::nullopt, no_exposure, 0};
  return mean_over_foreground(pair, map_at(pair, linear_display(1.0 / white)));
}

// Andersson, Nilsson, Shirley and Akenine-Moeller 2021, "Visualizing Errors in Rendered High
// Dynamic Range Images": exposures from the one that shows the reference's largest luminance at t =
// 0.85 to the one that shows its median there. They depend on the reference alone.
Measured measure_flip_hdr(const PreparedPair& pair) {
  const LuminanceRange& range = pair.reference_luminance;
  if (!(range.median > 0.0)) {
    return {std::nullopt,
            fmt::format("the reference's median luminance is {}, so that there is no longest "
                        "exposure",
                        range.median),
            0};
  }
  constexpr double shown_at = 0.85;
  const double stops = std::log2(range.maximum / range.median);
  const int exposures = std::max(2, static_cast<int>(std::ceil(stops)));
  const double shortest = inverse_tone(aces_display(1.0), shown_at) / range.maximum;
  Plane largest(pair.foreground.size(), 0.0f);
  for (int i = 0; i < exposures; ++i) {
    raise_to(largest,
             map_at(pair, aces_display(shortest * std::exp2(i * stops / (exposures - 1)))));
    // The exposures of a constant reference are all the same.
    if (stops == 0.0) break;
  }
  return mean_over_foreground(pair, largest);
}

}  // namespace occlab
