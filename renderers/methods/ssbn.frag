// SSBN: the bent normal and the uniform ambient occlusion [Klehm et al. 2011].
#include "renderers/methods/screen_space.glsl"
#include "renderers/shared/representation_bent_cone.h"

layout(location = 0) out vec4 out_bent_cone;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 p = texelFetch(position_view, pixel, 0);
  out_bent_cone = vec4(0.0);
  if (p.w == 0.0) return;
  vec3 n = normal_at(pixel);
  vec4 set = pixel_sample_set();
  mat3 frame = sampling_frame(n, set);
  vec4 sum = vec4(0.0);
  for (int j = 0; j < PARAMETER_samples; ++j) {
    vec4 s = sample_direction[j];
    vec3 direction = frame * s.xyz;
    float V = march_visibility(p.xyz, n, direction, fract(s.w + set.z), d_max_world);
    bent_cone_accumulate(sum, V, direction);
  }
  out_bent_cone = bent_cone_result(sum, PARAMETER_samples);
}
