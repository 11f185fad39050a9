// The equirect map of a light probe. Row 0 is the top (+Y); the image's centre is +X; u = 3/4 is
// +Z.
#pragma once
#include "renderers/shared/trigonometry.h"

SHARED_BEGIN

// (u, v) in [0, 1]^2 of unit direction d, probe space.
SHARED vec2 equirect_uv(vec3 d) {
  // Not the arccosine of d.y, which near the poles loses half of the digits.
  const float from_axis = sqrt(d.x * d.x + d.z * d.z);
  return vec2(0.5f + arctan2(d.z, d.x) * 0.1591549431f, arctan2(from_axis, d.y) * 0.3183098862f);
}

// Unit direction, probe space, of (u, v).
SHARED vec3 equirect_direction(vec2 uv) {
  const float phi = 2.0f * pi * (uv.x - 0.5f);
  const float elevation = pi * (0.5f - uv.y);
  return vec3(cos(elevation) * cos(phi), sin(elevation), cos(elevation) * sin(phi));
}

SHARED_END
