// What the passes with one bounce of light share: the blocker of a direction as a sender.
#pragma once
#include "renderers/methods/screen_space.glsl"
#include "renderers/shared/bounce.h"

// A blocker that sends light. Where nothing blocks, `pixel` is the receiver's own and `share` 0, so
// that looking its surface up is harmless.
struct Sender {
  vec3 to_sender;  // p' - p
  ivec2 pixel;     // that shows it
  int source;      // 0: as the first surface; i + 1: in layer or camera i
  float share;     // 1 - V
};

#ifdef HIDDEN_SURFACES

// march_visibility(), and what decides it.
float march_to_sender(vec3 p, vec3 n, vec3 s, float xi, float reach, out Sender sender) {
  Blocker blocker = first_blocker(p, n, s, xi, reach);
  bool found = blocker.distance >= 0.0;
  float visibility = visibility_behind(blocker);
  sender.to_sender = blocker.to_surface;
  sender.pixel = found ? blocker.pixel : ivec2(gl_FragCoord.xy);
  sender.source = blocker.source;
  sender.share = 1.0 - visibility;
  return visibility;
}

vec3 normal_of(Sender sender) {
  if (sender.source == 0) return normal_at(sender.pixel);
  return stored_normal(texelFetch(hidden_normal, ivec3(sender.pixel, sender.source - 1), 0).xyz);
}

vec3 albedo_of(Sender sender) {
  if (sender.source == 0) return texelFetch(albedo_map, sender.pixel, 0).rgb;
  return texelFetch(hidden_albedo, ivec3(sender.pixel, sender.source - 1), 0).rgb;
}

#else

// march_visibility(), and what decides it.
float march_to_sender(vec3 p, vec3 n, vec3 s, float xi, float reach, out Sender sender) {
  float visibility = 1.0;
  bool undecided = true;
  sender.to_sender = vec3(0.0);
  sender.pixel = ivec2(gl_FragCoord.xy);
  sender.source = 0;
  sender.share = 0.0;
  for (int k = 0; k < PARAMETER_steps; ++k) {
    vec3 q = march_point(p, s, reach, k, xi, PARAMETER_steps);
    vec2 pixel = project_to_pixel(q, image_center, focal_pixels);
    vec4 surface = vec4(0.0);
    if (on_screen(q, pixel, image_center)) surface = texelFetch(position_view, ivec2(pixel), 0);
    if (undecided && surface_blocks(surface, q, p, n, bias_world, epsilon_world, d_max_world)) {
      undecided = false;
      sender.to_sender = surface.xyz - p;
      sender.pixel = ivec2(pixel);
      visibility = blocked_visibility(PARAMETER_weight, length(sender.to_sender), d_max_world,
                                      lambda_per_world, fade_start);
      sender.share = 1.0 - visibility;
    }
  }
  return visibility;
}

vec3 normal_of(Sender sender) { return normal_at(sender.pixel); }
vec3 albedo_of(Sender sender) { return texelFetch(albedo_map, sender.pixel, 0).rgb; }

#endif

// (1 - V) f, for a direction with cosine n.s and the sender's normal.
float weighted_form_factor(Sender sender, vec3 n, vec3 n_sender, float cosine) {
#if PARAMETER_form_factor == FORM_FACTOR_SOLID_ANGLE
  return sender.share * solid_angle_form_factor(cosine, PARAMETER_samples);
#else
  float area = patch_area(sender_area, d_max_world, PARAMETER_samples);
  float least = least_distance(PARAMETER_distance_clamp, d_max_world, PARAMETER_samples);
  return sender.share * patch_form_factor(sender.to_sender, n, n_sender, area, least);
#endif
}
