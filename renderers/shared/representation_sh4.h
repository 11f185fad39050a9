// S3HO: 16 SH coefficients of visibility times the cosine lobe [Herholz et al. 2012].
#pragma once
#include "renderers/shared/sh.h"

SHARED_BEGIN

SHARED void sh4_accumulate(INOUT(Sh4) sum, float visibility, vec3 direction, float cosine) {
  sum = sh_add_scaled(sum, sh_basis(direction), visibility * cosine);
}

// c_i = (4 pi / (2 N)) sum V y_i(s) (n.s) [S3HO eq. 2].
SHARED Sh4 sh4_result(Sh4 sum, int sample_count) {
  return sh_scale(sum, 2.0f * pi / float(sample_count));
}

// E = c[Lin] . c[S3HO] [S3HO eq. 3]; may be negative.
SHARED vec3 sh4_irradiance(ShRgb light, Sh4 visibility) { return sh_dot_rgb(light, visibility); }

// k_A = (2 / sqrt(pi)) c_0.
SHARED float sh4_ambient_occlusion(Sh4 visibility) { return 1.1283791671f * visibility.c0.x; }

SHARED_END
