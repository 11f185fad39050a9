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

// [Depth peeling] Whether the sample is between the surfaces of a pair that are seen through its
// pixel one after the other: inside a solid, in front of which `front` is and behind which `back`
// is (w: 0 where there is none, and everything behind `front` counts) [SSDO sec. 4].
SHARED bool between_pair(vec4 front, vec4 back, vec3 q, float bias) {
  return front.w > 0.0f && front.z > q.z + bias && (back.w == 0.0f || back.z < q.z);
}

// [Additional cameras] A point of the view's space in that of another camera, given its matrix's
// columns.
SHARED vec3 in_camera(vec4 x, vec4 y, vec4 z, vec4 origin, vec3 q) {
  PRECISE vec3 moved = vec3(x) * q.x + vec3(y) * q.y + vec3(z) * q.z + vec3(origin);
  return moved;
}

// Whether a sample is in front of the first surface of its pixel, or there is none (seen: 0): it is
// in the open. z of both in the camera's space.
SHARED bool in_the_open(float seen, float surface_z, float sample_z, float bias) {
  return seen == 0.0f || surface_z <= sample_z + bias;
}

// Whether a hidden surface's triangle is seen from its back (1: from its front).
SHARED bool seen_from_back(float seen) { return seen > 1.5f; }

// The nearest to p of the surfaces that block a step. `source`: 0 for the first surface seen from
// the view's camera; i + 1 for that of layer or camera i.
struct Blocker {
  vec3 to_surface;  // p' - p
  float distance;   // squared; less than 0: nothing blocks
  int source;
  ivec2 pixel;
};

SHARED Blocker no_blocker() {
  Blocker none;
  none.to_surface = vec3(0.0f);
  none.distance = -1.0f;
  none.source = 0;
  none.pixel = ivec2(0);
  return none;
}

// `best`, or the surface if that is nearer to p, above the tangent plane and within d_max. The
// sample is known to be behind it (or, of the back of a pair, in front).
SHARED Blocker nearer_blocker(Blocker best, vec4 surface, int source, ivec2 pixel, vec3 p, vec3 n,
                              float epsilon, float d_max) {
  PRECISE vec3 to_surface = vec3(surface) - p;
  PRECISE float distance =
      to_surface.x * to_surface.x + to_surface.y * to_surface.y + to_surface.z * to_surface.z;
  if (surface.w == 0.0f || dot(to_surface, n) <= epsilon || distance > d_max * d_max) return best;
  if (best.distance >= 0.0f && best.distance <= distance) return best;
  best.to_surface = to_surface;
  best.distance = distance;
  best.source = source;
  best.pixel = pixel;
  return best;
}

SHARED_END
