// Real spherical harmonics up to band 3 (order 4, 16 coefficients), index i = l(l+1)+m, with the
// signs of Sloan, "Stupid Spherical Harmonics (SH) Tricks", 2008, appendix A2. Orthonormal.
#pragma once
#include "renderers/shared/half.h"

SHARED_BEGIN

// Coefficients 0-3, 4-7, 8-11 and 12-15.
struct Sh4 {
  vec4 c0;
  vec4 c1;
  vec4 c2;
  vec4 c3;
};

// Constructor syntax would do in GLSL and GCC, but not in clang before 16.
SHARED Sh4 sh4(vec4 c0, vec4 c1, vec4 c2, vec4 c3) {
  Sh4 a;
  a.c0 = c0;
  a.c1 = c1;
  a.c2 = c2;
  a.c3 = c3;
  return a;
}

// One coefficient vector a colour channel.
struct ShRgb {
  Sh4 r;
  Sh4 g;
  Sh4 b;
};

SHARED Sh4 sh_zero() { return sh4(vec4(0.0f), vec4(0.0f), vec4(0.0f), vec4(0.0f)); }

// y_i(d) for unit d.
SHARED Sh4 sh_basis(vec3 d) {
  const float xx = d.x * d.x;
  const float yy = d.y * d.y;
  const float zz = d.z * d.z;
  return sh4(
      vec4(0.2820947918f, -0.4886025119f * d.y, 0.4886025119f * d.z, -0.4886025119f * d.x),
      vec4(1.0925484306f * d.x * d.y, -1.0925484306f * d.y * d.z,
           0.3153915653f * (3.0f * zz - 1.0f), -1.0925484306f * d.x * d.z),
      vec4(0.5462742153f * (xx - yy), -0.5900435899f * d.y * (3.0f * xx - yy),
           2.8906114426f * d.x * d.y * d.z, -0.4570457995f * d.y * (5.0f * zz - 1.0f)),
      vec4(0.3731763326f * d.z * (5.0f * zz - 3.0f), -0.4570457995f * d.x * (5.0f * zz - 1.0f),
           1.4453057213f * d.z * (xx - yy), -0.5900435899f * d.x * (xx - 3.0f * yy)));
}

SHARED Sh4 sh_scale(Sh4 a, float s) { return sh4(a.c0 * s, a.c1 * s, a.c2 * s, a.c3 * s); }

// a + s b
SHARED Sh4 sh_add_scaled(Sh4 a, Sh4 b, float s) {
  return sh4(a.c0 + s * b.c0, a.c1 + s * b.c1, a.c2 + s * b.c2, a.c3 + s * b.c3);
}

SHARED float sh_dot(Sh4 a, Sh4 b) {
  return dot(a.c0, b.c0) + dot(a.c1, b.c1) + dot(a.c2, b.c2) + dot(a.c3, b.c3);
}

SHARED vec3 sh_dot_rgb(ShRgb a, Sh4 b) {
  return vec3(sh_dot(a.r, b), sh_dot(a.g, b), sh_dot(a.b, b));
}

// Multiplies band l by bands[l].
SHARED Sh4 sh_scale_bands(Sh4 a, vec4 bands) {
  return sh4(a.c0 * vec4(bands.x, bands.y, bands.y, bands.y), a.c1 * bands.z,
             a.c2 * vec4(bands.z, bands.w, bands.w, bands.w), a.c3 * bands.w);
}

// Rotates a function that is symmetric about +Z, given by its zonal coefficients z_l, to point
// along d: c_lm = sqrt(4 pi / (2l+1)) z_l y_lm(d).
SHARED Sh4 sh_zonal(vec4 z, vec3 d) {
  return sh_scale_bands(sh_basis(d),
                        z * vec4(3.5449077018f, 2.0466534158f, 1.5853309190f, 1.3398491713f));
}

// Zonal coefficients of the clamped cosine lobe max(0, z).
SHARED vec4 sh_cosine_lobe() { return vec4(0.8862269255f, 1.0233267079f, 0.4954159122f, 0.0f); }

// Irradiance factors of band l: convolution with the cosine lobe multiplies c_lm by A_l
// [Ramamoorthi and Hanrahan 2001].
SHARED vec4 sh_cosine_convolution() {
  return vec4(3.1415926536f, 2.0943951024f, 0.7853981634f, 0.0f);
}

// Hanning window w_l = (1 + cos(pi l / width)) / 2; width 0 means no window.
SHARED vec4 sh_hanning_window(float width) {
  if (width <= 0.0f) return vec4(1.0f);
  const vec4 l = min(vec4(0.0f, 1.0f, 2.0f, 3.0f) / width, vec4(1.0f));
  return 0.5f * (vec4(1.0f) + cos(pi * l));
}

// 16 coefficients as half pairs, 8 to a uvec4: "two Float32 targets" [S3HO sec. 3]. Integers,
// because as floats some bit patterns would be NaNs.
SHARED uvec4 sh_pack_low(Sh4 a) {
  return uvec4(pack_halves(a.c0.x, a.c0.y), pack_halves(a.c0.z, a.c0.w),
               pack_halves(a.c1.x, a.c1.y), pack_halves(a.c1.z, a.c1.w));
}

SHARED uvec4 sh_pack_high(Sh4 a) {
  return uvec4(pack_halves(a.c2.x, a.c2.y), pack_halves(a.c2.z, a.c2.w),
               pack_halves(a.c3.x, a.c3.y), pack_halves(a.c3.z, a.c3.w));
}

SHARED Sh4 sh_unpack(uvec4 low, uvec4 high) {
  return sh4(vec4(unpack_halves(low.x), unpack_halves(low.y)),
             vec4(unpack_halves(low.z), unpack_halves(low.w)),
             vec4(unpack_halves(high.x), unpack_halves(high.y)),
             vec4(unpack_halves(high.z), unpack_halves(high.w)));
}

SHARED_END
