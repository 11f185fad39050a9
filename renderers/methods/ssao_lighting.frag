// L_o = (rho/pi) k_A E_unoccluded(n).
#include "renderers/methods/screen_space.glsl"
#include "renderers/shared/representation_ao.h"

layout(binding = 5) uniform sampler2D ambient_occlusion;
layout(location = 0) out vec4 out_radiance;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 p = texelFetch(position_view, pixel, 0);
  out_radiance = vec4(0.0);
  if (p.w == 0.0) return;
  vec3 n = normal_at(pixel);
  vec3 E = unoccluded_irradiance(n);
#if LIGHT_COUNT > 0
  for (int i = 0; i < LIGHT_COUNT; ++i) {
    IncidentLight light = incident_light(lights[i], p.xyz);
    E += light.irradiance * max(dot(n, light.direction), 0.0);
  }
#endif
  float k_A = texelFetch(ambient_occlusion, pixel, 0).r;
  vec3 rho = texelFetch(albedo_map, pixel, 0).rgb;
  out_radiance = vec4(rho / pi * ao_irradiance(k_A, E), 1.0);
}
