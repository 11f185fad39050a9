// S3HO with one bounce: c[S3HO], and c[SSGI] of every blocker as the light that it would send if
// nothing blocked it, collected along the way [S3HO eq. 5].
#include "renderers/methods/bounce.glsl"
#include "renderers/shared/representation_sh_bounce.h"

ShBounce bounce;

float sample_visibility(vec3 p, vec3 n, vec3 s, float xi, float cosine) {
  Sender sender;
  float V = march_to_sender(p, n, s, xi, d_max_world, sender);
  vec3 n_sender = normal_of(sender);
  vec3 rho = albedo_of(sender);
  float f = weighted_form_factor(sender, n, n_sender, cosine);
  sh_bounce_accumulate(bounce, n_sender, f / pi * rho);
  return V;
}

#include "renderers/methods/s3ho_sampling.glsl"

layout(location = 0) out uvec4 out_low;
layout(location = 1) out uvec4 out_high;
layout(location = 2) out uvec4 out_red;
layout(location = 3) out uvec4 out_green;
layout(location = 4) out uvec4 out_blue;
layout(location = 5) out uvec4 out_last;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 p = texelFetch(position_view, pixel, 0);
  out_low = uvec4(0u);
  out_high = uvec4(0u);
  out_red = uvec4(0u);
  out_green = uvec4(0u);
  out_blue = uvec4(0u);
  out_last = uvec4(0u);
  if (p.w == 0.0) return;
  vec3 n = normal_at(pixel);
  vec4 set = pixel_sample_set();
  bounce = sh_bounce_zero();
  Sh4 c = visibility_sh(p.xyz, n, sampling_frame(n, set), set.z);
  bounce = sh_bounce_storable(bounce);
  out_low = sh_pack_low(c);
  out_high = sh_pack_high(c);
  out_red = sh_bounce_pack_colour(bounce.r0, bounce.r1);
  out_green = sh_bounce_pack_colour(bounce.g0, bounce.g1);
  out_blue = sh_bounce_pack_colour(bounce.b0, bounce.b1);
  out_last = sh_bounce_pack_last(bounce.last);
}
