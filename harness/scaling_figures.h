#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "harness/measurements.h"

namespace occlab {

/// One figure for every axis that has exponents, FOLDER/scaling_AXIS.png: the time of the pass that
/// does the work (the G-buffer's for triangles, else the occlusion's) and of the whole frame, a
/// line for each method. An axis has the rows whose other facts are the commonest ones: where axes
/// are varied one by one, those are the point they all start from. Nothing is written without
/// exponents.
void write_scaling_figures(const std::vector<Measurement>& measurements,
                           const std::filesystem::path& folder);

}  // namespace occlab
