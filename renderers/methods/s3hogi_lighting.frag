// L_o = (rho/pi) c[Lin] . (c[S3HO] + c[SSGI]), for each colour [S3HO eq. 3 to 5]. Not clamped.
#include "renderers/methods/screen_space.glsl"
#include "renderers/shared/representation_sh4.h"
#include "renderers/shared/representation_sh_bounce.h"

layout(std140, binding = 2) uniform EnvironmentBlock {
  ShRgb environment_sh;
};
layout(binding = 5) uniform usampler2D visibility_low;
layout(binding = 6) uniform usampler2D visibility_high;
layout(binding = 7) uniform usampler2D bounce_red;
layout(binding = 8) uniform usampler2D bounce_green;
layout(binding = 9) uniform usampler2D bounce_blue;
layout(binding = 10) uniform usampler2D bounce_last;
layout(location = 0) out vec4 out_radiance;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 p = texelFetch(position_view, pixel, 0);
  out_radiance = vec4(0.0);
  if (p.w == 0.0) return;
  Sh4 c = sh_unpack(texelFetch(visibility_low, pixel, 0), texelFetch(visibility_high, pixel, 0));
  ShBounce b = sh_bounce_unpack(texelFetch(bounce_red, pixel, 0), texelFetch(bounce_green, pixel, 0),
                                texelFetch(bounce_blue, pixel, 0),
                                texelFetch(bounce_last, pixel, 0));
  vec3 E = sh4_irradiance(environment_sh, c) + sh_bounce_irradiance(environment_sh, b);
#if LIGHT_COUNT > 0
  vec4 window = sh_hanning_window(hanning_width);
  for (int i = 0; i < LIGHT_COUNT; ++i) {
    IncidentLight light = incident_light(lights[i], p.xyz);
    Sh4 lobe = sh_scale_bands(sh_basis(light.direction), window);
    E += light.irradiance * (vec3(sh_dot(lobe, c)) + sh_bounce_dot(lobe, b));
  }
#endif
  vec3 rho = texelFetch(albedo_map, pixel, 0).rgb;
  out_radiance = vec4(rho / pi * E, 1.0);
}
