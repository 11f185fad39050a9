// The arctangent, the same on every device: GLSL leaves the precision of its own functions open,
// and Mesa's put directions up to 1e-4 rad off. No branches, so that loops over it vectorise.
#pragma once
#include "renderers/shared/glsl.h"

SHARED_BEGIN

// arctan2 to 1e-7 rad; 0 at the origin [Abramowitz and Stegun 4.4.49].
SHARED float arctan2(float y, float x) {
  const float ax = abs(x);
  const float ay = abs(y);
  const float larger = ax > ay ? ax : ay;
  const float smaller = ax > ay ? ay : ax;
  const float a = smaller / (larger > 0.0f ? larger : 1.0f);
  const float s = a * a;
  float p = 0.0028662257f;
  p = p * s - 0.0161657367f;
  p = p * s + 0.0429096138f;
  p = p * s - 0.0752896400f;
  p = p * s + 0.1065626393f;
  p = p * s - 0.1420889944f;
  p = p * s + 0.1999355085f;
  p = p * s - 0.3333314528f;
  float angle = a + a * s * p;
  angle = ay > ax ? 0.5f * pi - angle : angle;
  angle = x < 0.0f ? pi - angle : angle;
  return y < 0.0f ? -angle : angle;
}

SHARED_END
