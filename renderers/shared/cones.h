// Where SSBN's pre-convolved lighting L_c(direction, angle) lies in its levels.
#pragma once
#include "renderers/shared/glsl.h"

SHARED_BEGIN

const int cone_levels = 8;  // alpha_k = (k+1)/8 pi/2 [Klehm et al. 2011]

// The level, with fraction, of a cone's half-angle; smaller cones than the first read the first.
SHARED float cone_level(float angle) {
  return clamp(angle / (0.5f * pi / float(cone_levels)) - 1.0f, 0.0f, float(cone_levels - 1));
}

// v of the stored image, which has one row more beyond either pole.
SHARED float cone_row(float v, float rows) { return (v * (rows - 2.0f) + 1.0f) / rows; }

SHARED_END
