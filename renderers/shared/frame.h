// The tangent frame of a normal.
#pragma once
#include "renderers/shared/glsl.h"

SHARED_BEGIN

// Orthonormal, right-handed, columns (tangent, bitangent, n) for unit n; continuous but for the
// plane n.z = 0 [Duff et al. 2017, "Building an Orthonormal Basis, Revisited"].
SHARED mat3 tangent_frame(vec3 n) {
  const float sign_z = n.z >= 0.0f ? 1.0f : -1.0f;
  PRECISE float a = -1.0f / (sign_z + n.z);
  PRECISE float b = n.x * n.y * a;
  PRECISE vec3 tangent = vec3(1.0f + sign_z * n.x * n.x * a, sign_z * b, -sign_z * n.x);
  PRECISE vec3 bitangent = vec3(b, sign_z + n.y * n.y * a, -n.y);
  return mat3(tangent, bitangent, n);
}

// The tangent frame turned about n by the angle whose cosine and sin are set.x and set.y: that of a
// pixel's interleaved sample set.
SHARED mat3 sampling_frame(vec3 n, vec4 set) {
  const mat3 frame = tangent_frame(n);
  PRECISE vec3 tangent = set.x * frame[0] + set.y * frame[1];
  PRECISE vec3 bitangent = set.x * frame[1] - set.y * frame[0];
  return mat3(tangent, bitangent, n);
}

SHARED_END
