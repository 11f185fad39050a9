// What the method computes at a pixel, with the paper's equation.
#include "renderers/methods/screen_space.glsl"

layout(location = 0) out float out_k_A;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 p = texelFetch(position_view, pixel, 0);
  out_k_A = 0.0;
  if (p.w == 0.0) return;  // background
  vec3 n = normal_at(pixel);
  vec4 set = pixel_sample_set();
  mat3 frame = sampling_frame(n, set);
  float sum = 0.0;
  for (int j = 0; j < PARAMETER_samples; ++j) {
    vec4 s = sample_direction[j];  // tangent frame; s.z = n.s
    float V = march_visibility(p.xyz, n, frame * s.xyz, fract(s.w + set.z), d_max_world);
    sum += V * s.z;
  }
  out_k_A = strength * 2.0 * sum / float(PARAMETER_samples);
}
