// SSDO's second pass: every blocker sends what the first one left in the framebuffer [SSDO sec. 3],
// or in that of the layer or camera that shows it [SSDO sec. 4].
// Writes the irradiance of both.
#include "renderers/methods/bounce.glsl"

layout(binding = 5) uniform sampler2D direct_irradiance;
layout(binding = 6) uniform sampler2D lit_framebuffer;
#ifdef HIDDEN_SURFACES
layout(binding = 7) uniform sampler2DArray lit_hidden;  // as many layers as hidden surfaces
#endif
layout(location = 0) out vec4 out_irradiance;

vec3 lit(Sender sender) {
#ifdef HIDDEN_SURFACES
  if (sender.source > 0) {
    return texelFetch(lit_hidden, ivec3(sender.pixel, sender.source - 1), 0).rgb;
  }
#endif
  return texelFetch(lit_framebuffer, sender.pixel, 0).rgb;
}

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
    march_to_sender(p.xyz, n, frame * s.xyz, fract(s.w + set.z), d_max_world, sender);
    float f = weighted_form_factor(sender, n, normal_of(sender), s.z);
    E += f * lit(sender);
  }
  out_irradiance = vec4(texelFetch(direct_irradiance, pixel, 0).rgb + E, 1.0);
}
