// The share of a pixel's N S sample points that lie off the screen (those of all cameras) and so count as visible. The
// methods share their samples, so one such map serves them all.
#include "renderers/methods/screen_space.glsl"

layout(location = 0) out float out_share;

bool seen_by_a_camera(vec3 q) {
  if (on_screen(q, project_to_pixel(q, image_center, focal_pixels), image_center)) return true;
#ifdef HIDDEN_CAMERAS
  for (int i = 0; i < HIDDEN_CAMERAS; ++i) {
    mat4 m = camera_from_view[i];
    vec3 there = in_camera(m[0], m[1], m[2], m[3], q);
    vec2 place = project_to_pixel(there, camera_center, camera_focal_pixels);
    if (on_screen(there, place, camera_center)) return true;
  }
#endif
  return false;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 p = texelFetch(position_view, pixel, 0);
  out_share = 0.0;
  if (p.w == 0.0) return;
  vec4 set = pixel_sample_set();
  mat3 frame = sampling_frame(normal_at(pixel), set);
  int outside = 0;
  for (int j = 0; j < PARAMETER_samples; ++j) {
    vec4 s = sample_direction[j];
    vec3 direction = frame * s.xyz;
    float xi = fract(s.w + set.z);
    for (int k = 0; k < PARAMETER_steps; ++k) {
      vec3 q = march_point(p.xyz, direction, d_max_world, k, xi, PARAMETER_steps);
      if (!seen_by_a_camera(q)) ++outside;
    }
  }
  out_share = float(outside) / float(PARAMETER_samples * PARAMETER_steps);
}
