// The irradiance of one light, whose maps tell what it reaches; what their bias hides is looked for in
// screen space: one blocker on P ... P + b l, and P is in shadow [SSDO sec. 5].
#include "renderers/methods/screen_space.glsl"
#include "renderers/shared/shadow_map.h"

layout(binding = 5) uniform sampler2D geometric_normal_view;
layout(binding = 6) uniform sampler2DArray map_distance;  // a layer a face
layout(location = 0) out vec4 out_irradiance;

uniform mat4 light_from_view;
uniform mat3 face_from_light[6];
uniform int face_count;
uniform float map_low;
uniform float map_high;
uniform float rounding_world;

// Where a point is on the maps.
struct MapPlace {
  ivec3 texel;
  float distance;  // of the point, as the map has it
  float width;     // of what the map sees at the point, scene units
};

MapPlace map_place(vec3 p) {
  vec3 from_light = (light_from_view * vec4(p, 1.0)).xyz;
  vec3 q = face_from_light[0] * from_light;
  int face = 0;
  for (int i = 1; i < face_count; ++i) {
    vec3 candidate = face_from_light[i] * from_light;
    if (candidate.z < q.z) {
      q = candidate;
      face = i;
    }
  }
  int side = textureSize(map_distance, 0).x;
  MapPlace place;
#if PARALLEL_RAYS
  place.distance = -q.z;
  place.width = map_high - map_low;
  vec2 at = q.xy;
#else
  place.distance = length(from_light);
  place.width = (map_high - map_low) * -q.z;
  vec2 at = q.xy / -q.z;
#endif
  ivec2 texel = ivec2(floor((at - map_low) / (map_high - map_low) * float(side)));
  place.texel = ivec3(clamp(texel, 0, side - 1), face);
  return place;
}

IncidentLight light_at(vec3 p) {
#if VIRTUAL_LIGHT
  return incident_virtual_light(lights[0], p, bounce_clamp_world);
#else
  return incident_light(lights[0], p);
#endif
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 p = texelFetch(position_view, pixel, 0);
  out_irradiance = vec4(0.0);
  if (p.w == 0.0) return;
  vec3 n = normal_at(pixel);
  IncidentLight light = light_at(p.xyz);
  vec3 E = light.irradiance * dot(n, light.direction);
  // From behind the triangle no light arrives, whatever the shading normal says.
  float cosine = dot(texelFetch(geometric_normal_view, pixel, 0).xyz, light.direction);
  if (!(max(E.r, max(E.g, E.b)) > 0.0) || cosine <= 0.0) return;

  MapPlace place = map_place(p.xyz);
  float b = 0.0;
#if PARAMETER_shadow_bias == SHADOW_BIAS_SLOPE
  float patch_size = shadow_patch_size(place.width, float(textureSize(map_distance, 0).x));
  b = shadow_slope_bias(patch_size, cosine, most_slope);
#endif
  if (place.distance - b - rounding_world > texelFetch(map_distance, place.texel, 0).x) return;
#if PARAMETER_correction_samples > 0
  if (b > 0.0) E *= march_visibility(p.xyz, n, light.direction, 0.5, min(b, light.distance));
#endif
  out_irradiance = vec4(E, 1.0);
}
