#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "harness/measure.h"
#include "harness/metrics/metrics.h"

namespace occlab {

/// A reference's layers over the frame or a region.
struct ReferenceImages {
  std::string view;  ///< as measurements name it
  std::optional<Rectangle> rectangle;
  bool point = false;
  Image radiance;
  Image mask;
  Image variance;   ///< empty if the method gives none
  Image occlusion;  ///< empty if the method gives none

  /// All metrics (of a point none), and brightness.
  std::vector<MetricValue> measure(const Image& test) const;
};

/// One of the plan's references; the whole frame first.
struct Reference {
  std::string cell;  ///< id
  std::vector<ReferenceImages> images;
};

/// All cells that are references, with which the plan begins. `progress` is called before each.
std::vector<Reference> read_references(const std::vector<MeasuredCell>& cells,
                                       const std::vector<Region>& regions, const std::string& view,
                                       const ReadLayers& read,
                                       const std::function<void(std::size_t)>& progress);

}  // namespace occlab
