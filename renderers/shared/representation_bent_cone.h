// SSBN: bent normal and bent cone [Klehm et al. 2011, "Bent Normals and Cones in Screen-space"].
#pragma once
#include "renderers/shared/trigonometry.h"

SHARED_BEGIN

// The declared order of the parameter `cone_angle`.
const int cone_angle_linear = 0;
const int cone_angle_exact = 1;

// xyz: the sum of visible directions; w: the sum of visibilities.
SHARED void bent_cone_accumulate(INOUT(vec4) sum, float visibility, vec3 direction) {
  sum += visibility * vec4(direction, 1.0f);
}

// xyz: N_ss = sum V s / sum V, not normalised (0 where nothing is visible); w: the *uniform*
// ambient occlusion sum V / N.
SHARED vec4 bent_cone_result(vec4 sum, int sample_count) {
  if (sum.w <= 0.0f) return vec4(0.0f);
  return vec4(vec3(sum.x, sum.y, sum.z) / sum.w, sum.w / float(sample_count));
}

// Half-angle of the cone: linear, C = (1 - max(0, 2 |N_ss| - 1)) pi/2, as the paper has it; or the
// relation it linearises, exact for a cap: cos C = 2 |N_ss| - 1.
SHARED float bent_cone_angle(float bent_length, int mode) {
  const float cosine = clamp(2.0f * bent_length - 1.0f, 0.0f, 1.0f);
  // Not acos(), whose precision GLSL leaves open: Mesa's is 1e-4 rad off.
  if (mode == cone_angle_exact) return arctan2(sqrt((1.0f - cosine) * (1.0f + cosine)), cosine);
  return (1.0f - cosine) * pi * 0.5f;
}

// E = pi AO L_c(N, C) (N.n), where `cone_light` is L_c(N, C) = (t/pi) int_cone L cos with
// t = 1/(1 - cos C), and `bent_cosine` is N.n of the unit bent normal.
SHARED vec3 bent_cone_irradiance(float uniform_occlusion, vec3 cone_light, float bent_cosine) {
  return pi * uniform_occlusion * max(bent_cosine, 0.0f) * cone_light;
}

// The same for a distant light of irradiance E_perp: L_c of a delta light inside the cone is
// (t/pi) E_perp (N.l), outside it is 0.
SHARED vec3 bent_cone_delta_light(vec3 irradiance_perpendicular, float light_cosine, float angle) {
  const float cosine = cos(angle);
  if (light_cosine < cosine || light_cosine <= 0.0f) return vec3(0.0f);
  return irradiance_perpendicular * (light_cosine / (pi * max(1.0f - cosine, 1e-4f)));
}

SHARED_END
