// A shadow map's texel: how far the surface is from the light.
#include "renderers/gl/surface_color.glsl"

in vec3 position_view;  // the view is the light's

layout(location = 0) out float out_distance;

void main() {
#ifdef PARALLEL_RAYS
  out_distance = -position_view.z;
#else
  out_distance = length(position_view);
#endif
#ifdef MASKED
  if (surface_color().a < alpha_cutoff) discard;
#endif
}
