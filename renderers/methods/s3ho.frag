// S3HO: SH coefficients of visibility times the cosine lobe [S3HO eq. 2].
#include "renderers/methods/screen_space.glsl"
#include "renderers/shared/representation_sh4.h"

layout(location = 0) out uvec4 out_low;
layout(location = 1) out uvec4 out_high;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 p = texelFetch(position_view, pixel, 0);
  out_low = uvec4(0u);
  out_high = uvec4(0u);
  if (p.w == 0.0) return;
  vec3 n = normal_at(pixel);
  vec4 set = pixel_sample_set();
  mat3 frame = sampling_frame(n, set);
  Sh4 sum = sh_zero();
  for (int j = 0; j < PARAMETER_samples; ++j) {
    vec4 s = sample_direction[j];
    vec3 direction = frame * s.xyz;
    float V = march_visibility(p.xyz, n, direction, fract(s.w + set.z), d_max_world);
    sh4_accumulate(sum, V, direction, s.z);
  }
  Sh4 c = sh4_result(sum, PARAMETER_samples);
  out_low = sh_pack_low(c);
  out_high = sh_pack_high(c);
}
