#pragma once

#include <string_view>
#include <vector>

#include "harness/metrics/metrics.h"

namespace occlab {

/// How bright a picture itself is, whatever the reference: `mean_red`, `mean_green`, `mean_blue`
/// and `mean_luminance`, means over F of linear Rec.709 radiance, in the scene's units. They are no
/// errors: none is better than another. Test pixels in the mask that are not finite are counted,
/// and then every value is empty with that count as its reason. Throws InputError for images of
/// different size, other numbers of channels and an empty mask.
std::vector<MetricValue> measure_brightness(const Image& test, const Image& mask);

/// Their names and definitions, as `occlab list metrics` has those of errors.
struct BrightnessInfo {
  std::string_view name;
  std::string_view definition;
};
const std::vector<BrightnessInfo>& brightness_metrics();
bool is_brightness_metric(std::string_view name);

}  // namespace occlab
