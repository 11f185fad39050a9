// What measure.h has of regions.

#include <fmt/format.h>

#include "harness/measure.h"

namespace occlab {

std::string view_of_region(const std::string& view, const std::string& region) {
  return fmt::format("{} [{}]", view, region);
}

bool is_region(const Measurement& measurement) { return measurement.view.ends_with(']'); }

}  // namespace occlab
