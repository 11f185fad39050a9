#pragma once

#include "renderers/methods/representation.h"

namespace occlab {

/// The light of visible directions as irradiance, RGB [SSDO eq. 1].
const Representation& ssdo_representation();

}  // namespace occlab
