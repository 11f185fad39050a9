// The octahedral map of the sphere: like an equirect map, but without trigonometry [Engelhardt and
// Dachsbacher 2008, "Octahedron Environment Maps"]. The image's middle is +Y, its corners are -Y.
#pragma once
#include "renderers/shared/glsl.h"

SHARED_BEGIN

SHARED float sign_or_one(float x) { return x < 0.0f ? -1.0f : 1.0f; }

// (u, v) in [0, 1]^2 of the direction d, of any length but 0.
SHARED vec2 octahedral_uv(vec3 d) {
  PRECISE float scale = 1.0f / (abs(d.x) + abs(d.y) + abs(d.z));
  PRECISE float x = d.x * scale;
  PRECISE float z = d.z * scale;
  // The lower half is folded outwards over the upper one's edges.
  const float u = d.y < 0.0f ? (1.0f - abs(z)) * sign_or_one(x) : x;
  const float v = d.y < 0.0f ? (1.0f - abs(x)) * sign_or_one(z) : z;
  return vec2(0.5f + 0.5f * u, 0.5f + 0.5f * v);
}

// Takes u in [0, 1] to texels of a map of side x side, at most 2^13: just so much short of the side
// that u = 1 falls into the last.
SHARED float octahedral_scale(int side) { return float(side) - 0.0005f; }

// The texel that uv falls into.
SHARED ivec2 octahedral_texel(vec2 uv, int side) {
  const float scale = octahedral_scale(side);
  return ivec2(int(scale * uv.x), int(scale * uv.y));
}

// The point of the octahedron |x| + |y| + |z| = 1 at (u, v): a direction, not of length 1.
SHARED vec3 octahedral_point(vec2 uv) {
  const float u = 2.0f * uv.x - 1.0f;
  const float v = 2.0f * uv.y - 1.0f;
  const float y = 1.0f - abs(u) - abs(v);
  if (y >= 0.0f) return vec3(u, y, v);
  return vec3((1.0f - abs(v)) * sign_or_one(u), y, (1.0f - abs(u)) * sign_or_one(v));
}

SHARED_END
