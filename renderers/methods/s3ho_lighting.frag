// L_o = (rho/pi) c[Lin] . c[S3HO], c[Lin] = c[env] + sum c[l] [S3HO eq. 3 and 4]. Not clamped: the
// reader of the image clamps and counts.
#include "renderers/methods/screen_space.glsl"
#include "renderers/shared/representation_sh4.h"

layout(std140, binding = 2) uniform EnvironmentBlock {
  ShRgb environment_sh;
};
layout(binding = 5) uniform usampler2D visibility_low;
layout(binding = 6) uniform usampler2D visibility_high;
layout(location = 0) out vec4 out_radiance;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 p = texelFetch(position_view, pixel, 0);
  out_radiance = vec4(0.0);
  if (p.w == 0.0) return;
  Sh4 c = sh_unpack(texelFetch(visibility_low, pixel, 0), texelFetch(visibility_high, pixel, 0));
  vec3 E = sh4_irradiance(environment_sh, c);
#if LIGHT_COUNT > 0
  vec4 window = sh_hanning_window(hanning_width);
  for (int i = 0; i < LIGHT_COUNT; ++i) {
    IncidentLight light = incident_light(lights[i], p.xyz);
    E += light.irradiance * sh_dot(sh_scale_bands(sh_basis(light.direction), window), c);
  }
#endif
  vec3 rho = texelFetch(albedo_map, pixel, 0).rgb;
  out_radiance = vec4(rho / pi * E, 1.0);
}
