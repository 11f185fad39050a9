// SSDO: one look-up of the probe for each unblocked direction [SSDO eq. 1].
#include "renderers/methods/screen_space.glsl"
#include "renderers/shared/representation_radiance.h"

layout(location = 0) out vec4 out_irradiance;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 p = receiver_position(pixel);
  out_irradiance = vec4(0.0);
  if (p.w == 0.0) return;
  vec3 n = receiver_normal(pixel);
  vec4 set = pixel_sample_set();
  mat3 frame = sampling_frame(n, set);
  vec3 sum = vec3(0.0);
  for (int j = 0; j < PARAMETER_samples; ++j) {
    vec4 s = sample_direction[j];
    vec3 direction = frame * s.xyz;
    float V = march_visibility(p.xyz, n, direction, fract(s.w + set.z), d_max_world);
    // Looked up blocked or not: branches cost more where neighbours disagree.
    radiance_accumulate(sum, V, probe_radiance(direction), s.z);
  }
  vec3 E = radiance_irradiance(sum, PARAMETER_samples);
#if LIGHT_COUNT > 0
  // A punctual light is one more direction to march, up to the light or d_max.
  for (int i = 0; i < LIGHT_COUNT; ++i) {
    IncidentLight light = incident_light(lights[i], p.xyz);
    float cosine = dot(n, light.direction);
    if (cosine > 0.0) {
      float reach = min(d_max_world, light.distance);
      float V = march_visibility(p.xyz, n, light.direction, fract(sample_direction[0].w + set.z), reach);
      E += light.irradiance * (cosine * V);
    }
  }
#endif
  out_irradiance = vec4(E, 1.0);
}
