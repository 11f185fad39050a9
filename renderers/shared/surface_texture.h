// Surface textures, the same to the G-buffer's pass and to the ray tracer: level 0, bilinear or
// nearest, in full floats. The pass does not leave this to the device's sampler, whose shares have
// 8 bits and whose smaller levels are the driver's own; and its albedo is, as its positions and
// normals are, that of the point at the pixel's centre.
#pragma once
#include "renderers/shared/glsl.h"

SHARED_BEGIN

// What lies beyond the image's edges [glTF 2.0, section 3.8.4].
const int wrap_repeat = 0;
const int wrap_mirrored_repeat = 1;
const int wrap_clamp_to_edge = 2;

// The texels that a point's value is mixed from: columns low.x and high.x, rows low.y and high.y;
// `share` is how much of the high ones. Row 0 is the image's top.
struct TextureFootprint {
  ivec2 low;
  ivec2 high;
  vec2 share;
};

// A texture coordinate brought near the image: [0, 1], mirrored [0, 2].
SHARED float wrapped_coordinate(float u, int wrap) {
  if (wrap == wrap_repeat) return u - floor(u);
  if (wrap == wrap_mirrored_repeat) return u - 2.0f * floor(0.5f * u);
  return clamp(u, 0.0f, 1.0f);
}

// The column or row that stands for `i`, of a wrapped coordinate: at most one beyond its range.
SHARED int wrapped_texel(int i, int size, int wrap) {
  if (wrap == wrap_clamp_to_edge) return clamp(i, 0, size - 1);
  const int period = wrap == wrap_repeat ? size : 2 * size;
  const int inside = i < 0 ? i + period : (i >= period ? i - period : i);
  return inside < size ? inside : period - 1 - inside;
}

// `uv` is finite, (0, 0) the image's upper left corner; `size`: columns and rows; `wrap`: in u, v.
SHARED TextureFootprint texture_footprint(vec2 uv, ivec2 size, ivec2 wrap, bool nearest) {
  const vec2 inside = vec2(wrapped_coordinate(uv.x, wrap.x), wrapped_coordinate(uv.y, wrap.y));
  const float middle = nearest ? 0.0f : 0.5f;
  const vec2 texels = vec2(inside.x * float(size.x) - middle, inside.y * float(size.y) - middle);
  const vec2 first = floor(texels);
  const ivec2 low = ivec2(int(first.x), int(first.y));
  const int step = nearest ? 0 : 1;
  TextureFootprint result;
  result.low = ivec2(wrapped_texel(low.x, size.x, wrap.x), wrapped_texel(low.y, size.y, wrap.y));
  result.high = ivec2(wrapped_texel(low.x + step, size.x, wrap.x),
                      wrapped_texel(low.y + step, size.y, wrap.y));
  result.share = nearest ? vec2(0.0f, 0.0f) : texels - first;
  return result;
}

SHARED_END
