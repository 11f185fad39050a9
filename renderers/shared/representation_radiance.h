// SSDO: the light of each visible direction, looked up while sampling [Ritschel et al. 2009].
#pragma once
#include "renderers/shared/glsl.h"

SHARED_BEGIN

SHARED void radiance_accumulate(INOUT(vec3) sum, float visibility, vec3 radiance, float cosine) {
  sum += radiance * (visibility * cosine);
}

// E = (2 pi / N) sum L_in V (n.s) [SSDO eq. 1, without rho/pi].
SHARED vec3 radiance_irradiance(vec3 sum, int sample_count) {
  return sum * (2.0f * pi / float(sample_count));
}

SHARED_END
