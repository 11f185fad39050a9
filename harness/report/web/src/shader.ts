// What a panel shows of a layer, pixel by pixel.

export const vertexShader = `#version 300 es
void main() {
  gl_Position = vec4(4.0 * float(gl_VertexID & 1) - 1.0, 4.0 * float(gl_VertexID >> 1) - 1.0, 0.0, 1.0);
}`;

/** In the order of `display` below. */
export const displays = ["tone", "false", "signed", "relative", "angle", "share", "direction", "signed_map", "positive_map"] as const;
export type Display = (typeof displays)[number];
export const curves = ["clamp", "reinhard", "filmic"] as const;

/** False colour of luminance, in stops from the reference's mean luminance. */
export const falseColourStops: [number, number] = [-6, 3];
/** Relative differences are to at least this share of the mean luminance. */
export const relativeFloor = 0.01;

export const fragmentShader = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
uniform sampler2D image, reference, mask, maps;  // maps: row 0 signed, row 1 positive
uniform int display, curve, step_image, step_reference, channels, taps;
uniform bool has_mask;
uniform vec2 panel_origin, panel_size, center, frame;  // device pixels; the frame's pixels
uniform float pixels_per_device, exposure, mean_luminance, scale;
out vec4 colour;

const vec3 not_finite = vec3(1.0, 0.0, 1.0);
const vec3 background = vec3(0.5);

bool broken(vec3 c) { return any(isnan(c)) || any(isinf(c)); }
float luminance(vec3 c) { return channels == 1 ? c.r : dot(c, vec3(0.2126, 0.7152, 0.0722)); }
vec3 srgb(vec3 c) {
  c = clamp(c, 0.0, 1.0);
  return mix(12.92 * c, 1.055 * pow(max(c, vec3(0.0031308)), vec3(1.0 / 2.4)) - 0.055, greaterThan(c, vec3(0.0031308)));
}
vec3 map_colour(float position, float row) {
  if (isnan(position) || isinf(position)) return not_finite;
  int last = textureSize(maps, 0).x - 1;
  float along = clamp(position, 0.0, 1.0) * float(last);
  int left = min(int(along), last - 1);
  return mix(texelFetch(maps, ivec2(left, int(row)), 0).rgb, texelFetch(maps, ivec2(left + 1, int(row)), 0).rgb, along - float(left));
}
vec3 signed_colour(float value) { return map_colour(0.5 + 0.5 * value / scale, 0.0); }
vec3 positive_colour(float value) { return map_colour(value / scale, 1.0); }
vec3 toned(vec3 c) {
  c *= exposure;
  if (curve == 1) c = max(c, 0.0) / (1.0 + max(c, 0.0));
  if (curve == 2) {  // Narkowicz 2015, "ACES filmic tone mapping curve"
    c = max(c, 0.0);
    c = c * (2.51 * c + 0.03) / (c * (2.43 * c + 0.59) + 0.14);
  }
  return srgb(c);
}
vec3 stored(sampler2D layer, vec2 at, int step) {
  ivec2 texel = min(ivec2(at) / step, textureSize(layer, 0) - 1);
  return texelFetch(layer, texel, 0).rgb;
}
vec3 difference(vec3 c, vec3 r) {
  if (broken(r)) return not_finite;
  float error = luminance(c) - luminance(r);
  if (display == 2) return signed_colour(error / mean_luminance);
  if (display == 3) return signed_colour(error / max(luminance(r), ${relativeFloor} * mean_luminance));
  float lengths = length(c) * length(r);
  if (!(lengths > 0.0)) return background;  // black has no colour
  // Of the cross product: acos() of a cosine near 1 has no digits left.
  return positive_colour(degrees(atan(length(cross(c, r)), dot(c, r))));
}
vec3 shade(vec2 at) {
  if (has_mask && stored(mask, at, 1).r <= 0.5) return background;
  vec3 c = stored(image, at, step_image);
  if (channels == 1) c = c.rrr;
  if (broken(c)) return not_finite;
  if (display == 0) return toned(c);
  if (display == 1) {
    float y = luminance(c) / mean_luminance;
    float stops = y > 0.0 ? log2(y) : ${falseColourStops[0].toFixed(1)};
    return map_colour((stops - ${falseColourStops[0].toFixed(1)}) / ${(falseColourStops[1] - falseColourStops[0]).toFixed(1)}, 1.0);
  }
  if (display == 5) return srgb(c);
  if (display == 6) return 0.5 + 0.5 * c;
  if (display == 7) return signed_colour(c.r);
  if (display == 8) return positive_colour(c.r);
  vec3 r = stored(reference, at, step_reference);
  if (channels == 1) r = r.rrr;
  return difference(c, r);
}
void main() {
  vec2 device = gl_FragCoord.xy - panel_origin;
  device.y = panel_size.y - device.y;
  vec3 sum = vec3(0.0);
  float count = 0.0;
  for (int i = 0; i < taps * taps; ++i) {
    vec2 offset = (vec2(i % taps, i / taps) + 0.5) / float(taps) - 0.5;
    vec2 at = center + (device + offset - 0.5 * panel_size) * pixels_per_device;
    if (any(lessThan(at, vec2(0.0))) || any(greaterThanEqual(at, frame))) continue;
    sum += shade(at);
    count += 1.0;
  }
  colour = count > 0.0 ? vec4(sum / count, 1.0) : vec4(0.0);
}`;
