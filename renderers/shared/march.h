// The screen-space march, but for the look-up of the G-buffer. View space.
#pragma once
#include "renderers/shared/glsl.h"

SHARED_BEGIN

// Column and row (row 0 at the top) that a point in front of the camera projects to.
SHARED vec2 project_to_pixel(vec3 q, vec2 image_center, float focal_pixels) {
  PRECISE vec2 pixel = image_center + vec2(q.x, -q.y) * (focal_pixels / -q.z);
  return pixel;
}

// Whether q is in front of the camera and `pixel`, its projection, on the screen.
SHARED bool on_screen(vec3 q, vec2 pixel, vec2 image_center) {
  return q.z < 0.0f && pixel.x >= 0.0f && pixel.y >= 0.0f && pixel.x < 2.0f * image_center.x &&
         pixel.y < 2.0f * image_center.y;
}

// Point k of `steps` along s: t = reach (k + xi)/S, uniform in length.
SHARED vec3 march_point(vec3 p, vec3 s, float reach, int k, float xi, int steps) {
  PRECISE vec3 q = p + s * (reach * (float(k) + xi) / float(steps));
  return q;
}

// Whether `surface`, the first one seen through the pixel of sample q (w: 0 where there is none),
// blocks p with normal n: it is nearer to the camera than the sample, above the tangent plane and
// within d_max [S3HO sec. 2.1].
SHARED bool surface_blocks(vec4 surface, vec3 q, vec3 p, vec3 n, float bias, float epsilon,
                           float d_max) {
  const vec3 to_surface = vec3(surface) - p;
  return surface.w > 0.0f && surface.z > q.z + bias && dot(to_surface, n) > epsilon &&
         dot(to_surface, to_surface) <= d_max * d_max;
}

SHARED_END
