// The 8x8 geometry-aware bilateral filter of a representation: floats, or SH packed as halves.
#include "renderers/methods/screen_space.glsl"
#include "renderers/shared/filter.h"
#include "renderers/shared/sh.h"

#if INTEGER_TARGETS
layout(binding = 5) uniform usampler2D input_low;
layout(binding = 6) uniform usampler2D input_high;
layout(location = 0) out uvec4 out_low;
layout(location = 1) out uvec4 out_high;
#else
layout(binding = 5) uniform sampler2D input_map;
layout(location = 0) out vec4 out_value;
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
    }
  }
#if INTEGER_TARGETS
  sum = sh_scale(sum, 1.0 / weights);
  out_low = sh_pack_low(sum);
  out_high = sh_pack_high(sum);
#else
  out_value = sum / weights;
#endif
}
