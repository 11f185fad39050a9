// L_o = (rho/pi) E: the light is already in E.
#include "renderers/methods/screen_space.glsl"

layout(binding = 5) uniform sampler2D irradiance;
layout(location = 0) out vec4 out_radiance;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec3 rho = receiver_albedo(pixel);
  out_radiance = vec4(rho / pi * texelFetch(irradiance, pixel, 0).rgb, 1.0);
}
