// S3HO: SH coefficients of visibility times the cosine lobe [S3HO eq. 2].
#include "renderers/methods/screen_space.glsl"

float sample_visibility(vec3 p, vec3 n, vec3 s, float xi, float cosine) {
  return march_visibility(p, n, s, xi, d_max_world);
}

#include "renderers/methods/s3ho_sampling.glsl"

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
  Sh4 c = visibility_sh(p.xyz, n, sampling_frame(n, set), set.z);
  out_low = sh_pack_low(c);
  out_high = sh_pack_high(c);
}
