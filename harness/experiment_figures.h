#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "harness/config.h"
#include "harness/error_budget.h"
#include "harness/measure.h"

namespace occlab {

/// The budget that a cell belongs to.
using ReadBudget = std::function<const StoredBudget&(const PlannedCell&)>;

/// The cells of one of the experiment's benches.
struct FigureBench {
  std::vector<MeasuredCell> cells;  ///< the references first
  ReadLayers read;
  ReadBudget read_budget;
};

/// Draws the experiment's figures from its cells (of several seeds, the first) and writes
/// FOLDER/NAME.png; of an error budget also the maps, FOLDER/NAME.exr with the layers METHOD_PART,
/// in mean luminances; of ambient occlusion and of lobes the numbers, FOLDER/NAME.json. Without a
/// reference cell there is no exposure to share: InputError.
/// `benches`: those of the experiment, in their order.
void write_figures(const Experiment& experiment, const std::vector<FigureBench>& benches,
                   const std::filesystem::path& folder);

}  // namespace occlab
