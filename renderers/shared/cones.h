// Where SSBN's pre-convolved lighting L_c(direction, angle) lies in its levels.
#pragma once
#include "renderers/shared/glsl.h"

SHARED_BEGIN

const int cone_levels = 8;  // alpha_k = (k+1)/8 pi/2 [Klehm et al. 2011]

// The level, with fraction, of a cone's half-angle; smaller cones than the first read the first.
// The fraction is linear in the cosine, not in the angle: L_c of a constant L is (1 + cos alpha) L,
// so that between levels it stays exact.
SHARED float cone_level(float angle) {
  const float step = 0.5f * pi / float(cone_levels);
  const float lower = clamp(floor(angle / step) - 1.0f, 0.0f, float(cone_levels - 2));
  const float narrow = cos((lower + 1.0f) * step);
  const float wide = cos((lower + 2.0f) * step);
  return lower + clamp((narrow - cos(angle)) / (narrow - wide), 0.0f, 1.0f);
}

// v of the stored image, which has one row more beyond either pole.
SHARED float cone_row(float v, float rows) { return (v * (rows - 2.0f) + 1.0f) / rows; }

SHARED_END
