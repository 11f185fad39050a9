// A scalar: the cosine-weighted share of visible directions, k_A [Landis 2002; S3HO sec. 1.1].
#pragma once
#include "renderers/shared/glsl.h"

SHARED_BEGIN

SHARED void ao_accumulate(INOUT(float) sum, float visibility, float cosine) {
  sum += visibility * cosine;
}

// k_A = (2/N) sum V (n.s) for N directions uniform over the hemisphere; 1 where nothing occludes.
SHARED float ao_result(float sum, int sample_count) { return 2.0f * sum / float(sample_count); }

// E = k_A E_unoccluded(n).
SHARED vec3 ao_irradiance(float k_A, vec3 unoccluded_irradiance) {
  return k_A * unoccluded_irradiance;
}

SHARED_END
