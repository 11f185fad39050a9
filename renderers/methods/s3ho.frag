// S3HO: SH coefficients of visibility times the cosine lobe [S3HO eq. 2].
#include "renderers/methods/screen_space.glsl"
#include "renderers/shared/representation_sh4.h"
#include "renderers/shared/sh_rotation.h"

layout(location = 0) out uvec4 out_low;
layout(location = 1) out uvec4 out_high;

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
      float V = march_visibility(p, n, frame * s.xyz, fract(s.w + shift), d_max_world);
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
    float V = march_visibility(p, n, direction, fract(s.w + shift), d_max_world);
    sh4_accumulate(sum, V, direction, s.z);
  }
  return sh4_result(sum, PARAMETER_samples);
}

#endif

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
