// One bounce of light: what a blocker, now a sender, adds to the irradiance of the point that it
// blocks, E = sum (1 - V) f L_o with L_o the radiance that it sends.
#pragma once
#include "renderers/shared/glsl.h"

SHARED_BEGIN

// The declared order of the parameter `form_factor`.
const int form_factor_solid_angle = 0;
const int form_factor_patch = 1;

// The declared order of the parameter `distance_clamp`.
const int distance_clamp_unit = 0;
const int distance_clamp_patch_radius = 1;
const int distance_clamp_none = 2;

// f = (2 pi / N) (n.s): the sender fills the solid angle that its direction stands for. Bounded,
// and exact where the sender is what the direction meets.
SHARED float solid_angle_form_factor(float cosine, int sample_count) {
  return 2.0f * pi / float(sample_count) * cosine;
}

// A_s: `share` of pi r_max^2 / N, the base of the hemisphere divided among N samples [SSDO sec. 3].
SHARED float patch_area(float share, float d_max, int sample_count) {
  return share * pi * d_max * d_max / float(sample_count);
}

// What the distance to a sender is clamped to: 1 scene unit [SSDO sec. 3]; the radius of the patch,
// r_max / sqrt(N), which does not depend on units; or 0.
SHARED float least_distance(int clamp, float d_max, int sample_count) {
  if (clamp == distance_clamp_unit) return 1.0f;
  return clamp == distance_clamp_patch_radius ? d_max / sqrt(float(sample_count)) : 0.0f;
}

// f = A_s cos+ theta_s cos+ theta_r / d^2 [SSDO sec. 3; S3HO eq. 5]. There is no 1/pi: the paper's
// rho/pi is the receiver's. `to_sender` = p' - p, of any length; n and n_sender are unit normals of
// receiver and sender.
SHARED float patch_form_factor(vec3 to_sender, vec3 n, vec3 n_sender, float area, float least) {
  const float d = sqrt(max(dot(to_sender, to_sender), 1e-12f));
  const float receives = max(dot(n, to_sender), 0.0f) / d;
  const float sends = max(-dot(n_sender, to_sender), 0.0f) / d;
  const float clamped = max(d, least);
  return area * receives * sends / (clamped * clamped);
}

SHARED_END
