#pragma once

#include "renderers/scene/environment.h"
#include "renderers/scene/gltf_file.h"

namespace occlab {

/// The sky that a case of a scene file asks for (scenes/FORMAT.md). Equal skies have equal names.
/// Throws InputError naming file and key.
Environment read_analytic_sky(const JsonValue& sky);

}  // namespace occlab
