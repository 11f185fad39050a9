// L_o = (rho/pi) pi AO L_c(N, C) (N.n) [Klehm et al. 2011].
#include "renderers/methods/screen_space.glsl"
#include "renderers/shared/representation_bent_cone.h"

layout(binding = 5) uniform sampler2D bent_cone;
layout(location = 0) out vec4 out_radiance;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 p = texelFetch(position_view, pixel, 0);
  out_radiance = vec4(0.0);
  if (p.w == 0.0) return;
  vec3 n = normal_at(pixel);
  vec4 bent = texelFetch(bent_cone, pixel, 0);
  float bent_length = length(bent.xyz);
  if (bent_length == 0.0) return;
  vec3 N = bent.xyz / bent_length;
  float angle = bent_cone_angle(bent_length, PARAMETER_cone_angle);
  vec3 L = cone_radiance(N, angle);
#if LIGHT_COUNT > 0
  for (int i = 0; i < LIGHT_COUNT; ++i) {
    IncidentLight light = incident_light(lights[i], p.xyz);
    L += bent_cone_delta_light(light.irradiance, dot(N, light.direction), angle);
  }
#endif
  vec3 rho = texelFetch(albedo_map, pixel, 0).rgb;
  out_radiance = vec4(rho / pi * bent_cone_irradiance(bent.w, L, dot(N, n)), 1.0);
}
