#pragma once

#include <functional>
#include <string>
#include <vector>

#include "harness/config.h"
#include "harness/measurements.h"
#include "renderers/scene/image_io.h"

namespace occlab {

/// A finished cell, as the measuring needs it.
struct MeasuredCell {
  const PlannedCell& planned;
  std::string id;
};

/// The layers of a cell; may throw InputError where it is not to be had.
using ReadLayers = std::function<Layers(const MeasuredCell&)>;

/// Is given measured rows, in their order.
using RowSink = std::function<void(std::vector<Measurement>)>;

/// The images of a cell that are measured, by their stage: before and after the filter. A method
/// that does not filter has only the unfiltered one. They are those of `layers`.
struct StageImage {
  std::string name;
  const Image& image;
};
std::vector<StageImage> stage_images(const Layers& layers);

/// "main [90-degree corner]": the view of a region's measurements.
std::string view_of_region(const std::string& view, const std::string& region);
bool is_region(const Measurement& measurement);

/// All metrics of all cells against the reference cell, before and after the filter: seed by seed;
/// their mean over the seeds; noise and bias over the seeds; and ratios and differences of two
/// methods with the same parameters, paired by seed. `cells` is the whole plan, the reference
/// first. `progress` is called before each cell. `identity` fills what all rows share.
///
/// Every group's rows go to `sink` as soon as it is measured; of earlier groups only what later
/// ones are compared with stays in memory.
void measure_cells(const std::vector<MeasuredCell>& cells, const std::vector<Region>& regions,
                   const Measurement& identity, const ReadLayers& read,
                   const std::function<void(std::size_t)>& progress, const RowSink& sink);

}  // namespace occlab
