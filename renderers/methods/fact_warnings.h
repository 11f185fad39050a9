#pragma once

#include <string>
#include <vector>

#include "renderers/methods/parameters.h"
#include "renderers/scene/image_io.h"

namespace occlab {

/// What a user should know of a rendering's facts (OcclusionMethod::evaluate()), in a sentence
/// each: open meshes, cameras that see nothing, light that has nothing to bounce from.
std::vector<std::string> fact_warnings(const ParameterSet& parameters, const Metadata& facts);

}  // namespace occlab
