#pragma once

#include <filesystem>
#include <vector>

#include "harness/config.h"
#include "harness/measure.h"

namespace occlab {

/// Draws the experiment's figures from its cells (of several seeds, the first) and writes
/// FOLDER/NAME.png. Without a reference cell there is no exposure to share: InputError.
void write_figures(const Experiment& experiment, const std::vector<MeasuredCell>& cells,
                   const ReadLayers& read, const std::filesystem::path& folder);

}  // namespace occlab
