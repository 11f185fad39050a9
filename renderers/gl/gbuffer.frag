in vec3 position_view;
in vec3 normal_view;
in vec2 texture_uv;

uniform vec3 material_albedo;
uniform int textured;
layout(binding = 0) uniform sampler2D albedo_texture;

layout(location = 0) out vec4 out_position;
layout(location = 1) out vec4 out_normal;
layout(location = 2) out vec4 out_geometric_normal;
layout(location = 3) out vec4 out_albedo;

void main() {
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
  vec3 albedo = material_albedo;
  if (textured != 0) albedo *= texture(albedo_texture, texture_uv).rgb;
  out_albedo = vec4(albedo, 1.0);
}
