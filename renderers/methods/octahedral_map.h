#pragma once

#include "renderers/scene/environment.h"

namespace occlab {

/// Texels across the map of a probe, a power of two: of a blurred one so many that they are at most
/// a tenth of its blur's sigma wide, at least 64, as a small map stays in caches; of others about
/// the size of the probe's own at its equator, 512 to 2048.
int octahedral_side(const Environment& environment);

/// The radiance of a probe by shared/octahedral.h, probe space: RGB, square. A texel is the mean of
/// the probe over its solid angle, as packed_radiance.h holds it.
Image octahedral_map(const Environment& environment);

}  // namespace occlab
