// The march through more than the first surfaces [SSDO sec. 4]: HIDDEN_LAYERS of them behind the
// first, or those that HIDDEN_CAMERAS other cameras see. One of the two is defined.
#pragma once
#include "renderers/shared/march.h"

// View space; w: 0 where no surface is seen.
layout(binding = 11) uniform sampler2DArray hidden_position;
// Only where there is a bounce.
layout(binding = 12) uniform sampler2DArray hidden_normal;
layout(binding = 13) uniform sampler2DArray hidden_albedo;

#ifdef HIDDEN_LAYERS

// Pairs of a pixel: the first surface and layer 0, layers 1 and 2, ... The last may have no back.
Blocker blocker_at(vec3 q, vec3 p, vec3 n) {
  Blocker blocker = no_blocker();
  vec2 place = project_to_pixel(q, image_center, focal_pixels);
  if (!on_screen(q, place, image_center)) return blocker;
  ivec2 pixel = ivec2(place);
  vec4 front = texelFetch(position_view, pixel, 0);
  for (int i = 0; i <= HIDDEN_LAYERS; i += 2) {
    vec4 back = i < HIDDEN_LAYERS ? texelFetch(hidden_position, ivec3(pixel, i), 0) : vec4(0.0);
    if (between_pair(front, back, q, bias_world)) {
      blocker = nearer_blocker(blocker, front, i, pixel, p, n, epsilon_world, d_max_world);
      blocker = nearer_blocker(blocker, back, i + 1, pixel, p, n, epsilon_world, d_max_world);
    }
    front = i + 1 < HIDDEN_LAYERS ? texelFetch(hidden_position, ivec3(pixel, i + 1), 0) : vec4(0.0);
  }
  return blocker;
}

#else

uniform mat4 camera_from_view[HIDDEN_CAMERAS];
uniform vec2 camera_center;
uniform float camera_focal_pixels;

// A sample that a camera sees to be free is free, whatever others say; one that is behind what all
// of those see that have it on their screens is blocked by what is near enough. What a camera sees
// from its back tells nothing: the camera is inside of it, or below an open floor.
Blocker blocker_at(vec3 q, vec3 p, vec3 n) {
  Blocker blocker = no_blocker();
  vec2 place = project_to_pixel(q, image_center, focal_pixels);
  if (on_screen(q, place, image_center)) {
    vec4 surface = texelFetch(position_view, ivec2(place), 0);
    if (in_the_open(surface.w, surface.z, q.z, bias_world)) return no_blocker();
    blocker = nearer_blocker(blocker, surface, 0, ivec2(place), p, n, epsilon_world, d_max_world);
  }
  for (int i = 0; i < HIDDEN_CAMERAS; ++i) {
    mat4 m = camera_from_view[i];
    vec3 there = in_camera(m[0], m[1], m[2], m[3], q);
    place = project_to_pixel(there, camera_center, camera_focal_pixels);
    if (!on_screen(there, place, camera_center)) continue;
    vec4 surface = texelFetch(hidden_position, ivec3(place, i), 0);
    if (seen_from_back(surface.w)) continue;
    float z = in_camera(m[0], m[1], m[2], m[3], surface.xyz).z;
    if (in_the_open(surface.w, z, there.z, bias_world)) return no_blocker();
    blocker =
        nearer_blocker(blocker, surface, i + 1, ivec2(place), p, n, epsilon_world, d_max_world);
  }
  return blocker;
}

#endif

// The blocker that decides direction s: that of the first step that has one.
Blocker first_blocker(vec3 p, vec3 n, vec3 s, float xi, float reach) {
  Blocker blocker = no_blocker();
  for (int k = 0; k < PARAMETER_steps && blocker.distance < 0.0; ++k) {
    blocker = blocker_at(march_point(p, s, reach, k, xi, PARAMETER_steps), p, n);
  }
  return blocker;
}

// V of what was found.
float visibility_behind(Blocker blocker) {
  if (blocker.distance < 0.0) return 1.0;
  return blocked_visibility(PARAMETER_weight, sqrt(blocker.distance), d_max_world, lambda_per_world,
                            fade_start);
}
