#include "renderers/gl/surface_color.glsl"

in vec3 position_view;
in vec3 normal_view;

#ifdef PEELED
layout(binding = 1) uniform sampler2D previous_depth;  // only what lies behind it is seen
#endif
#ifdef OTHER_EYE
uniform vec3 eye_view;
#define FROM_EYE (position_view - eye_view)
#else
#define FROM_EYE position_view
#endif
// PEELED and OTHER_EYE: out_position.w is 1 where a triangle is seen from its front, 2 from its back.
// With POSITIONS_ONLY there are no other outputs.
#if defined(PEELED) || defined(OTHER_EYE)
#define SEEN (gl_FrontFacing ? 1.0 : 2.0)
#else
#define SEEN 1.0
#endif

layout(location = 0) out vec4 out_position;
#ifndef POSITIONS_ONLY
layout(location = 1) out vec4 out_normal;
layout(location = 2) out vec4 out_geometric_normal;
layout(location = 3) out vec4 out_albedo;
#endif

void main() {
  vec4 color = surface_color();
  out_position = vec4(position_view, SEEN);
#ifndef POSITIONS_ONLY
  // Surfaces are two-sided: both normals are turned to the viewer's side of the triangle.
  vec3 shading = normalize(normal_view);
  vec3 across = cross(dFdx(position_view), dFdy(position_view));
  float squared = dot(across, across);
  // The derivatives reach beyond the triangle; where that runs behind the camera or a sliver leaves
  // nothing to derive, the shading normal stands in.
  bool derived = squared > 0.0 && squared < 1e30;
  vec3 geometric = derived ? across * inversesqrt(squared) : shading;
  if (dot(geometric, FROM_EYE) > 0.0) geometric = -geometric;
#ifdef PEELED
  // The viewer is inside of what is seen from its back: it sends light to the other side.
  if (!gl_FrontFacing) geometric = -geometric;
#endif
  if (dot(shading, geometric) < 0.0) shading = -shading;
  out_normal = vec4(shading, 0.0);
  out_geometric_normal = vec4(geometric, 0.0);
  out_albedo = vec4(color.rgb, 1.0);
#endif
#ifdef MASKED
  // Last, as derivatives are only defined where all of a quad's pixels go on.
  if (color.a < alpha_cutoff) discard;
#endif
#ifdef PEELED
  if (gl_FragCoord.z <= texelFetch(previous_depth, ivec2(gl_FragCoord.xy), 0).x) discard;
#endif
}
