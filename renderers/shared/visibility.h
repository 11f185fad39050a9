// What a blocker at a distance lets through.
#pragma once
#include "renderers/shared/glsl.h"

SHARED_BEGIN

// The declared order of the parameter `weight`.
const int weight_binary = 0;
const int weight_lambda = 1;
const int weight_smoothstep = 2;

// V of a direction whose first blocker is at distance d in (0, d_max]: 0 (binary);
// 1 - 1/(1 + lambda d) [S3HO sec. 2.1]; a fade to visible between fade_start d_max and d_max
// [SSDO sec. 4]. lambda is per scene unit. Where nothing is left of the fade, at fade_start 1 or an
// infinite d_max, smoothstep is undefined; its limit is that all blockers block.
SHARED float blocked_visibility(int weight, float d, float d_max, float lambda, float fade_start) {
  if (weight == weight_lambda) return lambda * d / (1.0f + lambda * d);
  if (weight == weight_smoothstep && d > fade_start * d_max) {
    return smoothstep(fade_start * d_max, d_max, d);
  }
  return 0.0f;
}

SHARED_END
