// The 8x8 geometry-aware bilateral filter of a representation: floats, or SH packed as halves,
// alone or with those of a bounce.
#include "renderers/methods/screen_space.glsl"
#include "renderers/shared/filter.h"
#include "renderers/shared/sh.h"

#define FILTERS_BOUNCE (INTEGER_TARGETS && TARGET_COUNT == 6)
#if FILTERS_BOUNCE
#include "renderers/shared/representation_sh_bounce.h"
#endif

#if INTEGER_TARGETS
layout(binding = 5) uniform usampler2D input_low;
layout(binding = 6) uniform usampler2D input_high;
layout(location = 0) out uvec4 out_low;
layout(location = 1) out uvec4 out_high;
#else
layout(binding = 5) uniform sampler2D input_map;
layout(location = 0) out vec4 out_value;
#endif
#if FILTERS_BOUNCE
layout(binding = 7) uniform usampler2D input_red;
layout(binding = 8) uniform usampler2D input_green;
layout(binding = 9) uniform usampler2D input_blue;
layout(binding = 10) uniform usampler2D input_last;
layout(location = 2) out uvec4 out_red;
layout(location = 3) out uvec4 out_green;
layout(location = 4) out uvec4 out_blue;
layout(location = 5) out uvec4 out_last;
#endif

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
#if INTEGER_TARGETS
  Sh4 sum = sh_zero();
  out_low = uvec4(0u);
  out_high = uvec4(0u);
#else
  vec4 sum = vec4(0.0);
  out_value = sum;
#endif
#if FILTERS_BOUNCE
  ShBounce bounce = sh_bounce_zero();
  out_red = uvec4(0u);
  out_green = uvec4(0u);
  out_blue = uvec4(0u);
  out_last = uvec4(0u);
#endif
  vec4 p = texelFetch(position_view, pixel, 0);
  if (p.w == 0.0) return;
  vec3 n = normal_at(pixel);
  ivec2 last = textureSize(position_view, 0) - 1;
  float weights = 0.0;
  for (int y = filter_first; y <= filter_last; ++y) {
    for (int x = filter_first; x <= filter_last; ++x) {
      ivec2 neighbour = pixel + ivec2(x, y);
      ivec2 inside = clamp(neighbour, ivec2(0), last);
      vec4 p_neighbour = texelFetch(position_view, inside, 0);
      vec3 n_neighbour = normal_at(inside);
      float w = bilateral_weight(p.xyz, n, p_neighbour.xyz, n_neighbour, filter_power,
                                 WHOLE_FILTER_POWER, filter_scale * d_max_world);
      w *= neighbour == inside ? p_neighbour.w : 0.0;
      weights += w;
#if INTEGER_TARGETS
      sum = sh_add_scaled(
          sum, sh_unpack(texelFetch(input_low, inside, 0), texelFetch(input_high, inside, 0)), w);
#else
      sum += w * texelFetch(input_map, inside, 0);
#endif
#if FILTERS_BOUNCE
      bounce = sh_bounce_add_scaled(
          bounce,
          sh_bounce_unpack(texelFetch(input_red, inside, 0), texelFetch(input_green, inside, 0),
                           texelFetch(input_blue, inside, 0), texelFetch(input_last, inside, 0)),
          w);
#endif
    }
  }
#if INTEGER_TARGETS
  sum = sh_scale(sum, 1.0 / weights);
  out_low = sh_pack_low(sum);
  out_high = sh_pack_high(sum);
#else
  out_value = sum / weights;
#endif
#if FILTERS_BOUNCE
  bounce = sh_bounce_add_scaled(sh_bounce_zero(), bounce, 1.0 / weights);
  out_red = sh_bounce_pack_colour(bounce.r0, bounce.r1);
  out_green = sh_bounce_pack_colour(bounce.g0, bounce.g1);
  out_blue = sh_bounce_pack_colour(bounce.b0, bounce.b1);
  out_last = sh_bounce_pack_last(bounce.last);
#endif
}
