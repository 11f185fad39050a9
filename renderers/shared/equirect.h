// The equirect map of a light probe. Row 0 is the top (+Y); the image's centre is +X; u = 3/4 is
// +Z.
#pragma once
#include "renderers/shared/glsl.h"

SHARED_BEGIN

// (u, v) in [0, 1]^2 of unit direction d, probe space.
SHARED vec2 equirect_uv(vec3 d) {
  // GLSL leaves atan(0, 0) undefined; a level floor asks for it.
  const float phi = d.x == 0.0f && d.z == 0.0f ? 0.0f : atan(d.z, d.x);
  return vec2(0.5f + phi / (2.0f * pi), acos(clamp(d.y, -1.0f, 1.0f)) / pi);
}

// Unit direction, probe space, of (u, v).
SHARED vec3 equirect_direction(vec2 uv) {
  const float phi = 2.0f * pi * (uv.x - 0.5f);
  const float elevation = pi * (0.5f - uv.y);
  return vec3(cos(elevation) * cos(phi), sin(elevation), cos(elevation) * sin(phi));
}

SHARED_END
