// The geometry-aware bilateral filter [S3HO sec. 3]: two weights, surface distance and orientation.
#pragma once
#include "renderers/shared/glsl.h"

SHARED_BEGIN

// A true 8x8 window: an 8-box removes the 4x4 interleaved pattern exactly, a 7-box does not.
const int filter_first = -4;
const int filter_last = 3;

// x^n for n from 0 to 1023, by squaring: pow() takes a quarter of the filter's time.
SHARED float whole_power(float x, int n) {
  float result = 1.0f;
  for (int bit = 0; bit < 10; ++bit) {
    if (((n >> bit) & 1) != 0) result *= x;
    x *= x;
  }
  return result;
}

// ((n.n')/2 + 1/2)^power / (1 + |p-p'| / scale)^2 with scale = d_max [weights of Klehm et al. 2011,
// who have power 5 and scale 1 scene unit; dividing by d_max makes them independent of units].
// `whole`: the power, if it is a whole number below 1024, else -1.
SHARED float bilateral_weight(vec3 p, vec3 n, vec3 p_neighbour, vec3 n_neighbour, float power,
                              int whole, float scale) {
  const float alike = max(0.5f * dot(n, n_neighbour) + 0.5f, 0.0f);
  const float orientation = whole >= 0 ? whole_power(alike, whole) : pow(alike, power);
  const float distance_weight = 1.0f / (1.0f + length(p - p_neighbour) / scale);
  return orientation * distance_weight * distance_weight;
}

SHARED_END
