layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;

uniform mat4 clip_from_view;
uniform mat4 view_from_object;
uniform mat3 normal_from_object;

out vec3 position_view;
out vec3 normal_view;
out vec2 texture_uv;

void main() {
  vec4 p = view_from_object * vec4(position, 1.0);
  position_view = p.xyz;
  normal_view = normal_from_object * normal;
  texture_uv = uv;
  gl_Position = clip_from_view * p;
}
