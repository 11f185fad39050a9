#include "harness/figures/tone_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "harness/figures/colour_maps.h"
#include "harness/metrics/colour.h"
#include "harness/metrics/image_checks.h"
#include "harness/statistics.h"
#include "renderers/scene/error.h"

namespace occlab {

double shared_exposure(const Image& reference, const Image& mask) {
  require_shape(reference, "reference", reference, 3);
  require_shape(mask, "mask", reference, 1);
  const std::vector<std::size_t> foreground = foreground_pixels(mask);
  require_finite(reference, "reference", foreground);
  std::vector<double> luminances;
  luminances.reserve(foreground.size());
  for (const std::size_t index : foreground) {
    const auto rgb = reference.values().subspan(3 * index, 3);
    luminances.push_back(luminance({rgb[0], rgb[1], rgb[2]}));
  }
  const double white = quantile(luminances, 0.99);
  if (!(white > 0.0)) {
    throw InputError(
        fmt::format("reference image: the 99th percentile of its luminance is {}; a figure's "
                    "exposure needs a positive one",
                    white));
  }
  return 1.0 / white;
}

Image tone_map(const Image& radiance, double exposure, const Image& mask) {
  require_shape(radiance, "radiance", radiance, 3);
  require_shape(mask, "mask", radiance, 1);
  if (!(exposure > 0.0) || !std::isfinite(exposure)) {
    throw InputError(fmt::format("exposure {}: accepted: positive numbers", exposure));
  }
  Image display(radiance.width(), radiance.height(), 3);
  for (std::size_t i = 0; i < radiance.pixel_count(); ++i) {
    const auto source = radiance.values().subspan(3 * i, 3);
    const auto target = display.values().subspan(3 * i, 3);
    if (!(mask.values()[i] > 0.5f)) {
      std::ranges::copy(figure_background, target.begin());
    } else if (!std::ranges::all_of(source, [](float value) { return std::isfinite(value); })) {
      std::ranges::copy(not_finite_colour, target.begin());
    } else {
      for (std::size_t c = 0; c < 3; ++c) {
        const double exposed = std::clamp(double(source[c]) * exposure, 0.0, 1.0);
        target[c] = srgb_encode(static_cast<float>(exposed));
      }
    }
  }
  return display;
}

}  // namespace occlab
