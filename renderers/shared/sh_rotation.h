// Rotation of functions given by order-4 spherical harmonics.
#pragma once
#include "renderers/shared/sh.h"

SHARED_BEGIN

// About +Z by the angle whose cosine and sin are turn.x and turn.y: a function's pairs (m, -m) turn
// by m times the angle.
SHARED Sh4 sh_rotate_z(Sh4 a, vec2 turn) {
  const float c1 = turn.x;
  const float s1 = turn.y;
  const float c2 = c1 * c1 - s1 * s1;
  const float s2 = 2.0f * c1 * s1;
  const float c3 = c1 * c2 - s1 * s2;
  const float s3 = s1 * c2 + c1 * s2;
  return sh4(
      vec4(a.c0.x, c1 * a.c0.y + s1 * a.c0.w, a.c0.z, c1 * a.c0.w - s1 * a.c0.y),
      vec4(c2 * a.c1.x + s2 * a.c2.x, c1 * a.c1.y + s1 * a.c1.w, a.c1.z, c1 * a.c1.w - s1 * a.c1.y),
      vec4(c2 * a.c2.x - s2 * a.c1.x, c3 * a.c2.y + s3 * a.c3.w, c2 * a.c2.z + s2 * a.c3.z,
           c1 * a.c2.w + s1 * a.c3.y),
      vec4(a.c3.x, c1 * a.c3.y - s1 * a.c2.w, c2 * a.c3.z - s2 * a.c2.z,
           c3 * a.c3.w - s3 * a.c2.y));
}

// About +Y by the angle of cosine c and sine s, which takes +Z towards +X: Wigner's d-matrices in
// the real basis, where functions that are even and odd in y do not mix.
SHARED Sh4 sh_rotate_y(Sh4 a, float c, float s) {
  const float cc = c * c;
  const float cs = c * s;
  const float ss = s * s;
  // Bands 2 and 3 share 1 - c^2 = s^2 and 2 c^2 - 1.
  const float double_cosine = cc - ss;
  const float q2 = 0.8660254038f * ss;
  const float q3 = 0.9682458366f * ss;
  const float r3 = 1.2247448714f * cs;
  const float t3 = 1.5811388301f * cs;
  const float even_01 = s * (3.0618621785f * cc - 0.6123724357f);
  const float even_02 = 1.9364916731f * c * ss;
  const float even_03 = 0.7905694150f * s * ss;
  const float even_12 = s * (2.3717082451f * cc - 0.7905694150f);
  const float even_13 = 0.9682458366f * c * ss;
  const float even_23 = s * (0.6123724357f + 0.6123724357f * cc);
  return sh4(
      vec4(a.c0.x, a.c0.y, c * a.c0.z + s * a.c0.w, c * a.c0.w - s * a.c0.z),
      vec4(c * a.c1.x - s * a.c1.y, c * a.c1.y + s * a.c1.x,
           (1.0f - 1.5f * ss) * a.c1.z + 1.7320508076f * cs * a.c1.w + q2 * a.c2.x,
           double_cosine * a.c1.w + cs * (a.c2.x - 1.7320508076f * a.c1.z)),
      vec4((1.0f - 0.5f * ss) * a.c2.x + q2 * a.c1.z - cs * a.c1.w,
           (1.0f - 0.75f * ss) * a.c2.y - r3 * a.c2.z + q3 * a.c2.w,
           double_cosine * a.c2.z + r3 * a.c2.y - t3 * a.c2.w,
           (1.0f - 1.25f * ss) * a.c2.w + q3 * a.c2.y + t3 * a.c2.z),
      vec4(c * (2.5f * cc - 1.5f) * a.c3.x + even_01 * a.c3.y + even_02 * a.c3.z + even_03 * a.c3.w,
           c * (3.75f * cc - 2.75f) * a.c3.y - even_01 * a.c3.x + even_12 * a.c3.z +
               even_13 * a.c3.w,
           c * (1.5f * cc - 0.5f) * a.c3.z + even_02 * a.c3.x - even_12 * a.c3.y + even_23 * a.c3.w,
           c * (0.75f + 0.25f * cc) * a.c3.w - even_03 * a.c3.x + even_13 * a.c3.y -
               even_23 * a.c3.z));
}

// From a frame with orthonormal, right-handed columns into the space that they are given in: if a
// is f, this is g with g(frame d) = f(d). The frame is taken apart into turns about z, y and z.
SHARED Sh4 sh_rotate(Sh4 a, mat3 frame) {
  const vec3 n = frame[2];
  const float s = sqrt(n.x * n.x + n.y * n.y);
  vec2 first = vec2(n.z > 0.0f ? frame[0].x : -frame[0].x, frame[0].y);
  vec2 last = vec2(1.0f, 0.0f);
  if (s > 0.0f) {
    first = vec2(-frame[0].z, frame[1].z) / s;
    last = vec2(n.x, n.y) / s;
  }
  return sh_rotate_z(sh_rotate_y(sh_rotate_z(a, first), n.z, s), last);
}

SHARED_END
