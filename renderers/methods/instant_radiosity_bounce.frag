// What virtual point lights leave out because they are clamped near by: a bounce of the lit
// framebuffer, each sender with the share that its distance leaves [SSDO sec. 5, Fig. 12].
#include "renderers/methods/bounce.glsl"
#include "renderers/shared/shadow_map.h"

layout(binding = 5) uniform sampler2D lit_framebuffer;
layout(location = 0) out vec4 out_irradiance;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 p = texelFetch(position_view, pixel, 0);
  out_irradiance = vec4(0.0);
  if (p.w == 0.0) return;
  vec3 n = normal_at(pixel);
  vec4 set = pixel_sample_set();
  mat3 frame = sampling_frame(n, set);
  vec3 E = vec3(0.0);
  for (int j = 0; j < PARAMETER_samples; ++j) {
    vec4 s = sample_direction[j];
    Sender sender;
    march_to_sender(p.xyz, n, frame * s.xyz, fract(s.w + set.z), bounce_clamp_world, sender);
    float f = weighted_form_factor(sender, n, normal_at(sender.pixel), s.z);
    f *= clamped_share(length(sender.to_sender), bounce_clamp_world);
    E += f * texelFetch(lit_framebuffer, sender.pixel, 0).rgb;
  }
  out_irradiance = vec4(E, 1.0);
}
