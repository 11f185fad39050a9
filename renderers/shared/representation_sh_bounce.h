// S3HOGI's c[SSGI]: the light of blockers as SH coefficients of what they would send under any
// light, one vector a colour [S3HO eq. 5]. Kept apart from c[S3HO], to which the paper adds it: the
// sum is the same, the bounce can be shown on its own, and both together take the three vectors'
// room, as the cosine lobe has no band 3.
#pragma once
#include "renderers/shared/sh.h"

SHARED_BEGIN

// Coefficients 0-3, 4-7 and 8 of red, green and blue.
struct ShBounce {
  vec4 r0;
  vec4 r1;
  vec4 g0;
  vec4 g1;
  vec4 b0;
  vec4 b1;
  vec3 last;
};

SHARED ShBounce sh_bounce_zero() {
  ShBounce a;
  a.r0 = vec4(0.0f);
  a.r1 = vec4(0.0f);
  a.g0 = vec4(0.0f);
  a.g1 = vec4(0.0f);
  a.b0 = vec4(0.0f);
  a.b1 = vec4(0.0f);
  a.last = vec3(0.0f);
  return a;
}

// Adds `strength` c[cos], the lobe about the sender's unit normal; strength = (1 - V) f rho/pi with
// the sender's rho [S3HO eq. 5].
SHARED void sh_bounce_accumulate(INOUT(ShBounce) sum, vec3 n_sender, vec3 strength) {
  const Sh4 lobe = sh_zonal(sh_cosine_lobe(), n_sender);
  sum.r0 += strength.x * lobe.c0;
  sum.r1 += strength.x * lobe.c1;
  sum.g0 += strength.y * lobe.c0;
  sum.g1 += strength.y * lobe.c1;
  sum.b0 += strength.z * lobe.c0;
  sum.b1 += strength.z * lobe.c1;
  sum.last += strength * lobe.c2.x;
}

// a + s b
SHARED ShBounce sh_bounce_add_scaled(ShBounce a, ShBounce b, float s) {
  a.r0 += s * b.r0;
  a.r1 += s * b.r1;
  a.g0 += s * b.g0;
  a.g1 += s * b.g1;
  a.b0 += s * b.b0;
  a.b1 += s * b.b1;
  a.last += s * b.last;
  return a;
}

SHARED vec4 storable(vec4 v) { return clamp(v, vec4(-65504.0f), vec4(65504.0f)); }

// Within what a half holds: a form factor that is not clamped may grow without bounds.
SHARED ShBounce sh_bounce_storable(ShBounce a) {
  a.r0 = storable(a.r0);
  a.r1 = storable(a.r1);
  a.g0 = storable(a.g0);
  a.g1 = storable(a.g1);
  a.b0 = storable(a.b0);
  a.b1 = storable(a.b1);
  a.last = clamp(a.last, vec3(-65504.0f), vec3(65504.0f));
  return a;
}

// c[Lin] . c[SSGI] of a light of one colour, all its channels 1.
SHARED vec3 sh_bounce_dot(Sh4 light, ShBounce c) {
  return vec3(dot(light.c0, c.r0) + dot(light.c1, c.r1), dot(light.c0, c.g0) + dot(light.c1, c.g1),
              dot(light.c0, c.b0) + dot(light.c1, c.b1)) +
         light.c2.x * c.last;
}

// E_ind = c[Lin] . c[SSGI] for each colour; may be negative.
SHARED vec3 sh_bounce_irradiance(ShRgb light, ShBounce c) {
  return vec3(dot(light.r.c0, c.r0) + dot(light.r.c1, c.r1) + light.r.c2.x * c.last.x,
              dot(light.g.c0, c.g0) + dot(light.g.c1, c.g1) + light.g.c2.x * c.last.y,
              dot(light.b.c0, c.b0) + dot(light.b.c1, c.b1) + light.b.c2.x * c.last.z);
}

// Four targets of half pairs: coefficients 0 to 7 of red, of green and of blue, and the last ones.
SHARED uvec4 sh_bounce_pack_colour(vec4 low, vec4 high) {
  return uvec4(pack_halves(low.x, low.y), pack_halves(low.z, low.w), pack_halves(high.x, high.y),
               pack_halves(high.z, high.w));
}

SHARED uvec4 sh_bounce_pack_last(vec3 last) {
  return uvec4(pack_halves(last.x, last.y), pack_halves(last.z, 0.0f), 0u, 0u);
}

SHARED vec4 unpack_four_halves(uint low, uint high) {
  return vec4(unpack_halves(low), unpack_halves(high));
}

SHARED ShBounce sh_bounce_unpack(uvec4 red, uvec4 green, uvec4 blue, uvec4 last) {
  ShBounce a;
  a.r0 = unpack_four_halves(red.x, red.y);
  a.r1 = unpack_four_halves(red.z, red.w);
  a.g0 = unpack_four_halves(green.x, green.y);
  a.g1 = unpack_four_halves(green.z, green.w);
  a.b0 = unpack_four_halves(blue.x, blue.y);
  a.b1 = unpack_four_halves(blue.z, blue.w);
  a.last = vec3(unpack_halves(last.x), unpack_halves(last.y).x);
  return a;
}

SHARED_END
