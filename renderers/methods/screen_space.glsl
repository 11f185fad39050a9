// What the passes of every screen-space method share: the G-buffer, the samples, the march.
// All vectors are in view space.
#pragma once
#include "renderers/shared/cones.h"
#include "renderers/shared/equirect.h"
#include "renderers/shared/frame.h"
#include "renderers/shared/lights.h"
#include "renderers/shared/march.h"
#include "renderers/shared/octahedral.h"
#include "renderers/shared/packed_radiance.h"
#include "renderers/shared/visibility.h"

layout(binding = 0) uniform sampler2D position_view;  // w: 1 where a surface is seen
layout(binding = 1) uniform sampler2D normal_view;
layout(binding = 2) uniform sampler2D albedo_map;
layout(binding = 3) uniform usamplerBuffer octahedral_probe;  // row by row
layout(binding = 4) uniform sampler2DArray cone_light;  // L_c, 8 levels

// sample_direction[N]: tangent frame; w: march offset. Constants of the program, unless there are
// too many.
layout(std140, binding = 0) uniform SampleBlock {
  vec4 sample_set[16];  // cos, sin of the turn; z: offset shift
#ifdef SAMPLES_IN_BUFFER
  vec4 sample_direction[PARAMETER_samples];
#endif
};

#if LIGHT_COUNT > 0
layout(std140, binding = 1) uniform LightBlock {
  PunctualLight lights[LIGHT_COUNT];
};
#endif

uniform float focal_pixels;
uniform vec2 image_center;
uniform mat3 probe_from_view;

// A normal as it is stored, unit; as halves it is up to 2^-10 off that.
vec3 stored_normal(vec3 n) {
#if PARAMETER_gbuffer_bits == GBUFFER_BITS_16
  n = n / sqrt(dot(n, n));
#endif
  return n;
}

// The shading normal.
vec3 normal_at(ivec2 pixel) { return stored_normal(texelFetch(normal_view, pixel, 0).xyz); }

vec4 pixel_sample_set() {
  ivec2 pixel = ivec2(gl_FragCoord.xy) & 3;
  return sample_set[pixel.x + 4 * pixel.y];
}

#if defined(HIDDEN_LAYERS) || defined(HIDDEN_CAMERAS)
#define HIDDEN_SURFACES
#include "renderers/methods/hidden_march.glsl"

// As below, through what is hidden too.
float march_visibility(vec3 p, vec3 n, vec3 s, float xi, float reach) {
  return visibility_behind(first_blocker(p, n, s, xi, reach));
}

#else

// The first surface seen through the pixel that q falls into; w = 0 where that is background or off
// the screen.
vec4 surface_at(vec3 q) {
  vec2 pixel = project_to_pixel(q, image_center, focal_pixels);
  if (!on_screen(q, pixel, image_center)) return vec4(0.0);
  return texelFetch(position_view, ivec2(pixel), 0);
}

// Screen-space visibility V of direction s from p with normal n: S steps at t = reach (k + xi)/S,
// the first surface that blocks decides [S3HO sec. 2.1].
float march_visibility(vec3 p, vec3 n, vec3 s, float xi, float reach) {
  float visibility = 1.0;
  bool undecided = true;  // a blocker at d_max may let all light through, and still decides
  for (int k = 0; k < PARAMETER_steps; ++k) {
    vec3 q = march_point(p, s, reach, k, xi, PARAMETER_steps);
    vec4 surface = surface_at(q);
    if (undecided && surface_blocks(surface, q, p, n, bias_world, epsilon_world, d_max_world)) {
      undecided = false;
      visibility = blocked_visibility(PARAMETER_weight, length(surface.xyz - p), d_max_world,
                                      lambda_per_world, fade_start);
    }
  }
  return visibility;
}

#endif

// The surface that a pass of direct light shades: the first one, or, as a sender, a hidden one.
#ifdef HIDDEN_RECEIVER
uniform int receiver;  // layer of the arrays
vec4 receiver_position(ivec2 pixel) {
  return texelFetch(hidden_position, ivec3(pixel, receiver), 0);
}
vec3 receiver_normal(ivec2 pixel) {
  return stored_normal(texelFetch(hidden_normal, ivec3(pixel, receiver), 0).xyz);
}
vec3 receiver_albedo(ivec2 pixel) {
  return texelFetch(hidden_albedo, ivec3(pixel, receiver), 0).rgb;
}
#else
vec4 receiver_position(ivec2 pixel) { return texelFetch(position_view, pixel, 0); }
vec3 receiver_normal(ivec2 pixel) { return normal_at(pixel); }
vec3 receiver_albedo(ivec2 pixel) { return texelFetch(albedo_map, pixel, 0).rgb; }
#endif

// The probe's radiance from direction s: the nearest texel.
vec3 probe_radiance(vec3 s) {
  ivec2 texel = octahedral_texel(octahedral_uv(probe_from_view * s), PROBE_SIDE);
  return unpack_radiance(texelFetch(octahedral_probe, texel.y * PROBE_SIDE + texel.x).xy);
}

// L_c(d, angle) of the pre-convolved levels, linear in the angle.
vec3 cone_radiance(vec3 d, float angle) {
  vec2 uv = equirect_uv(probe_from_view * d);
  uv.y = cone_row(uv.y, float(textureSize(cone_light, 0).y));
  float level = cone_level(angle);
  float lower = floor(level);
  vec3 a = textureLod(cone_light, vec3(uv, lower), 0.0).rgb;
  vec3 b = textureLod(cone_light, vec3(uv, min(lower + 1.0, float(cone_levels - 1))), 0.0).rgb;
  return mix(a, b, level - lower);
}

// The irradiance of the whole probe on a surface with normal n.
vec3 unoccluded_irradiance(vec3 n) {
  return pi * cone_radiance(n, 0.5 * pi);
}
