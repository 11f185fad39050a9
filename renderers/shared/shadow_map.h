// Shadow maps: the bias that keeps surfaces from shadowing themselves, and virtual point lights.
#pragma once
#include "renderers/shared/lights.h"

SHARED_BEGIN

// The declared order of the parameter `shadow_bias`.
const int shadow_bias_none = 0;
const int shadow_bias_slope = 1;

// p, the size of the patch that a texel stands for, in scene units: the diagonal of `width` /
// `side`, where `width` is that of what the map sees at the receiver. The paper does not say which
// of a patch's sizes it means; its corners are what has to be moved below the surface [SSDO sec.
// 5].
SHARED float shadow_patch_size(float width, float side) { return 1.41421356f * width / side; }

// b = (p/2) tan(alpha), alpha being the angle between the surface's normal and the direction toward
// the light, of which `cosine` > 0 is the cosine; tan(alpha) is taken for at most `most_slope`
// [SSDO sec. 5, Fig. 8].
SHARED float shadow_slope_bias(float patch_size, float cosine, float most_slope) {
  const float slope = sqrt(max(1.0f - cosine * cosine, 0.0f)) / cosine;
  return 0.5f * patch_size * min(slope, most_slope);
}

// A virtual point light stands for a patch that sends the flux Phi it reflects by the cosine of the
// angle to its normal: E_perp = (Phi/pi) cos+ theta_s / d^2, with d no less than `least_distance`.
// `light`: intensity Phi/pi, direction the patch's normal [Keller 1997; SSDO sec. 5].
SHARED IncidentLight incident_virtual_light(PunctualLight light, vec3 p, float least_distance) {
  const vec3 to_light = vec3(light.position_and_type) - p;
  const float d = sqrt(max(dot(to_light, to_light), 1e-12f));
  const vec3 direction = to_light / d;
  const float sends = max(-dot(vec3(light.direction_and_outer), direction), 0.0f);
  const float clamped = max(d, least_distance);
  return incident_from(direction, vec3(light.intensity_and_inner) * (sends / (clamped * clamped)),
                       d);
}

// What virtual point lights leave out of the light of senders at distance d, as a share of it:
// 1/d^2 - 1/max(d, least)^2 = share/d^2.
SHARED float clamped_share(float d, float least_distance) {
  if (d >= least_distance) return 0.0f;
  const float ratio = d / least_distance;
  return 1.0f - ratio * ratio;
}

SHARED_END
