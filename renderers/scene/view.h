#pragma once

#include <cmath>

#include "renderers/scene/scene.h"

namespace occlab {

/// A camera at a resolution. View space is the camera's: +X right, +Y up, looking along -Z. The
/// vertical field of view is the camera's whatever the aspect; pixels are square.
struct View {
  Camera camera;
  int width = 1280;
  int height = 720;

  /// Distance of the film from the pinhole, in pixels: a point projects to column
  /// W/2 + f x/(-z) and row H/2 - f y/(-z), row 0 at the top.
  float focal_pixels() const { return 0.5f * float(height) / std::tan(0.5f * camera.yfov); }
  glm::mat4 view_from_world() const { return glm::inverse(camera.world_from_camera); }
  glm::mat3 world_from_view_rotation() const { return glm::mat3(camera.world_from_camera); }
};

}  // namespace occlab
