#include "renderers/methods/visibility_source.h"

#include <algorithm>

#include "renderers/shared/frame.h"
#include "renderers/shared/march.h"
#include "renderers/shared/visibility.h"

namespace occlab {
namespace {

glm::vec3 vec3_at(const Image& image, glm::ivec2 pixel) {
  return {image.at(pixel.x, pixel.y, 0), image.at(pixel.x, pixel.y, 1),
          image.at(pixel.x, pixel.y, 2)};
}

void set_lane(Lanes3& lanes, int lane, glm::vec3 value) {
  lanes.x[lane] = value.x;
  lanes.y[lane] = value.y;
  lanes.z[lane] = value.z;
}

/// screen_space.glsl's march_visibility.
class DepthMarch {
 public:
  DepthMarch(const GBufferImages& surface, const View& view, const PassConstants& constants)
      : surface_(surface),
        constants_(constants),
        image_center_(0.5f * glm::vec2(view.width, view.height)),
        focal_pixels_(view.focal_pixels()) {}

  Lanes operator()(const PixelGroup& group, const LaneDirections& direction, float xi,
                   const Lanes& reach) const {
    Lanes visible;
    for (int i = 0; i < lane_count; ++i) {
      const auto lane = std::size_t(i);
      if (group.active[i]) {
        visible[i] = march(group.position[lane], group.normal[lane], direction[lane], xi, reach[i]);
      }
    }
    return visible;
  }

 private:
  glm::vec4 surface_at(glm::vec3 q) const {
    const glm::vec2 pixel = project_to_pixel(q, image_center_, focal_pixels_);
    if (!on_screen(q, pixel, image_center_)) return glm::vec4(0.0f);
    const glm::ivec2 texel(pixel);
    return {vec3_at(surface_.position_view, texel), surface_.mask.at(texel.x, texel.y)};
  }

  float march(glm::vec3 p, glm::vec3 n, glm::vec3 s, float xi, float reach) const {
    for (int k = 0; k < constants_.steps; ++k) {
      const glm::vec3 q = march_point(p, s, reach, k, xi, constants_.steps);
      const glm::vec4 surface = surface_at(q);
      if (surface_blocks(surface, q, p, n, constants_.bias_world, constants_.epsilon_world,
                         constants_.d_max_world)) {
        const BlockerWeight& blocker = constants_.blocker;
        return blocked_visibility(blocker.weight, length(glm::vec3(surface) - p),
                                  blocker.d_max_world, blocker.lambda_per_world,
                                  blocker.fade_start);
      }
    }
    return 1.0f;
  }

  const GBufferImages& surface_;
  PassConstants constants_;
  glm::vec2 image_center_;
  float focal_pixels_;
};

}  // namespace

PixelGroup pixel_group(const GBufferImages& surface, const SampleSet& samples, glm::ivec2 corner,
                       int set) {
  PixelGroup group;
  for (int i = 0; i < lane_count; ++i) {
    const auto lane = std::size_t(i);
    const glm::ivec2 pixel = corner + glm::ivec2(set % 4 + 4 * (i % 4), set / 4 + 4 * (i / 4));
    const bool inside = pixel.x < surface.mask.width() && pixel.y < surface.mask.height();
    if (!inside || surface.mask.at(pixel.x, pixel.y) < 0.5f) continue;
    group.active[i] = -1;
    group.any = true;
    group.pixel[lane] = pixel;
    group.position[lane] = vec3_at(surface.position_view, pixel);
    group.normal[lane] = vec3_at(surface.normal_view, pixel);
    group.geometric_normal[lane] = vec3_at(surface.geometric_normal_view, pixel);
    group.frame[lane] = sampling_frame(group.normal[lane], samples.sets[std::size_t(set)]);
  }
  return group;
}

VisibilitySource depth_visibility(const GBufferImages& surface, const View& view,
                                  const PassConstants& constants) {
  return DepthMarch(surface, view, constants);
}

VisibilitySource traced_visibility(const TracedScene& traced, const View& view,
                                   const PassConstants& constants) {
  const glm::mat3 rotation = view.world_from_view_rotation();
  const glm::vec3 eye(view.camera.world_from_camera[3]);
  const float lift = traced.ray_lift_world();
  const BlockerWeight blocker = constants.blocker;
  return [=, &traced](const PixelGroup& group, const LaneDirections& direction, float,
                      const Lanes& reach) {
    Lanes3 origin;
    Lanes3 along;
    for (int i = 0; i < lane_count; ++i) {
      const auto lane = std::size_t(i);
      set_lane(
          origin, i,
          eye + rotation * group.position[lane] + lift * (rotation * group.geometric_normal[lane]));
      set_lane(along, i, rotation * direction[lane]);
    }
    return PacketVisibility(traced, blocker)(origin, group.active, along, reach);
  };
}

}  // namespace occlab
