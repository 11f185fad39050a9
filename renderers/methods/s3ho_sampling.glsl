// c[S3HO] of a pixel [S3HO eq. 2]. Who includes this has defined
//     float sample_visibility(vec3 p, vec3 n, vec3 s, float xi, float cosine),
// V of direction s with cosine n.s and march offset xi.
#pragma once
#include "renderers/shared/representation_sh4.h"
#include "renderers/shared/sh_rotation.h"

#ifdef PROJECTS_BITS

// In the frame that is turned with the set, directions and their products are the same at every
// pixel: the loop only collects which are visible.
Sh4 visibility_sh(vec3 p, vec3 n, mat3 frame, float shift) {
  uint visible[(PARAMETER_samples + 31) / 32];
  for (int word = 0; word < visible.length(); ++word) {
    uint bits = 0u;
    int first = 32 * word;
    for (int j = first; j < min(first + 32, PARAMETER_samples); ++j) {
      vec4 s = sample_direction[j];
      float V = sample_visibility(p, n, frame * s.xyz, fract(s.w + shift), s.z);
      bits |= V > 0.0 ? 1u << (j - first) : 0u;
    }
    visible[word] = bits;
  }
  Sh4 c;
  project_visibility(visible, c.c0, c.c1, c.c2, c.c3);
  return sh_rotate(c, frame);
}

#else

Sh4 visibility_sh(vec3 p, vec3 n, mat3 frame, float shift) {
  Sh4 sum = sh_zero();
  for (int j = 0; j < PARAMETER_samples; ++j) {
    vec4 s = sample_direction[j];
    vec3 direction = frame * s.xyz;
    float V = sample_visibility(p, n, direction, fract(s.w + shift), s.z);
    sh4_accumulate(sum, V, direction, s.z);
  }
  return sh4_result(sum, PARAMETER_samples);
}

#endif
