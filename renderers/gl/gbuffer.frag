#include "renderers/shared/surface_texture.h"

in vec3 position_view;
in vec3 normal_view;
in vec2 texture_uv;

uniform vec3 material_albedo;
uniform float material_alpha;
#ifdef TEXTURED
uniform int wrap_u;
uniform int wrap_v;
uniform int nearest_texel;
layout(binding = 0) uniform sampler2D albedo_texture;
#endif
#ifdef MASKED
uniform float alpha_cutoff;
#endif

layout(location = 0) out vec4 out_position;
layout(location = 1) out vec4 out_normal;
layout(location = 2) out vec4 out_geometric_normal;
layout(location = 3) out vec4 out_albedo;

vec4 surface_color() {
  vec4 factor = vec4(material_albedo, material_alpha);
#ifdef TEXTURED
  TextureFootprint at = texture_footprint(texture_uv, textureSize(albedo_texture, 0),
                                          ivec2(wrap_u, wrap_v), nearest_texel != 0);
  vec4 top = mix(texelFetch(albedo_texture, at.low, 0),
                 texelFetch(albedo_texture, ivec2(at.high.x, at.low.y), 0), at.share.x);
  vec4 bottom = mix(texelFetch(albedo_texture, ivec2(at.low.x, at.high.y), 0),
                    texelFetch(albedo_texture, at.high, 0), at.share.x);
  return factor * mix(top, bottom, at.share.y);
#else
  return factor;
#endif
}

void main() {
  vec4 color = surface_color();
  // Surfaces are two-sided: both normals are turned to the viewer's side of the triangle.
  vec3 shading = normalize(normal_view);
  vec3 across = cross(dFdx(position_view), dFdy(position_view));
  float squared = dot(across, across);
  // The derivatives reach beyond the triangle; where that runs behind the camera or a sliver leaves
  // nothing to derive, the shading normal stands in.
  bool derived = squared > 0.0 && squared < 1e30;
  vec3 geometric = derived ? across * inversesqrt(squared) : shading;
  if (dot(geometric, position_view) > 0.0) geometric = -geometric;
  if (dot(shading, geometric) < 0.0) shading = -shading;
  out_position = vec4(position_view, 1.0);
  out_normal = vec4(shading, 0.0);
  out_geometric_normal = vec4(geometric, 0.0);
  out_albedo = vec4(color.rgb, 1.0);
#ifdef MASKED
  // Last, as derivatives are only defined where all of a quad's pixels go on.
  if (color.a < alpha_cutoff) discard;
#endif
}
