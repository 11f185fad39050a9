// What measure.h has of regions.

#include <fmt/format.h>

#include <algorithm>

#include "harness/measure.h"

namespace occlab {

std::string view_of_region(const std::string& view, const std::string& region) {
  return fmt::format("{} [{}]", view, region);
}

bool is_region(const Measurement& measurement) { return measurement.view.ends_with(']'); }

std::vector<Region> regions(const Experiment& experiment) {
  std::vector<Region> all;
  for (const FigureSettings& figure : experiment.figures) {
    for (const CloseupRow& row : figure.rows) {
      if (std::ranges::find(all, row.label, &Region::name) == all.end()) {
        all.push_back({row.label, row.rectangle});
      }
    }
  }
  return all;
}

}  // namespace occlab
