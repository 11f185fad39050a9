#include "renderers/methods/visibility_source.h"

#include <algorithm>

#include "renderers/scene/interrupt.h"
#include "renderers/scene/parallel.h"
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

}  // namespace

DepthMarch::DepthMarch(const GBufferImages& surface, const View& view,
                       const PassConstants& constants)
    : surface_(surface),
      constants_(constants),
      image_center_(0.5f * glm::vec2(view.width, view.height)),
      focal_pixels_(view.focal_pixels()) {}

std::optional<glm::ivec2> DepthMarch::pixel_of(glm::vec3 q) const {
  const glm::vec2 pixel = project_to_pixel(q, image_center_, focal_pixels_);
  if (!on_screen(q, pixel, image_center_)) return std::nullopt;
  return glm::ivec2(pixel);
}

DepthMarch::Result DepthMarch::march(const ShadedPoint& point, glm::vec3 direction, float xi,
                                     float reach, int first_step) const {
  for (int k = first_step; k < constants_.steps; ++k) {
    const glm::vec3 q = march_point(point.position, direction, reach, k, xi, constants_.steps);
    const std::optional<glm::ivec2> pixel = pixel_of(q);
    if (!pixel) continue;
    const glm::vec4 surface(vec3_at(surface_.position_view, *pixel),
                            surface_.mask.at(pixel->x, pixel->y));
    if (surface_blocks(surface, q, point.position, point.normal, constants_.bias_world,
                       constants_.epsilon_world, constants_.d_max_world)) {
      const BlockerWeight& blocker = constants_.blocker;
      const float visibility =
          blocked_visibility(blocker.weight, length(glm::vec3(surface) - point.position),
                             blocker.d_max_world, blocker.lambda_per_world, blocker.fade_start);
      return {visibility, true, k, q, *pixel};
    }
  }
  return {};
}

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

void for_each_group(const GBufferImages& surface, const SampleSet& samples,
                    const std::function<void(const PixelGroup& group, int set)>& body) {
  constexpr int block_size = 16;
  const int columns = (surface.mask.width() + block_size - 1) / block_size;
  const int rows = (surface.mask.height() + block_size - 1) / block_size;
  parallel_for(std::size_t(columns * rows), [&](std::size_t block) {
    throw_if_interrupted();
    const glm::ivec2 corner = block_size * glm::ivec2(int(block) % columns, int(block) / columns);
    for (int set = 0; set < int(samples.sets.size()); ++set) {
      const PixelGroup group = pixel_group(surface, samples, corner, set);
      if (group.any) body(group, set);
    }
  });
}

GroupRays rays_of(const PixelGroup& group, const LaneDirections& direction, const View& view,
                  float lift_world) {
  const glm::mat3 rotation = view.world_from_view_rotation();
  const glm::vec3 eye(view.camera.world_from_camera[3]);
  GroupRays rays;
  for (int i = 0; i < lane_count; ++i) {
    const auto lane = std::size_t(i);
    set_lane(rays.origin, i,
             eye + rotation * group.position[lane] +
                 lift_world * (rotation * group.geometric_normal[lane]));
    set_lane(rays.direction, i, rotation * direction[lane]);
  }
  return rays;
}

VisibilitySource depth_visibility(const GBufferImages& surface, const View& view,
                                  const PassConstants& constants) {
  return
      [march = DepthMarch(surface, view, constants)](
          const PixelGroup& group, const LaneDirections& direction, float xi, const Lanes& reach) {
        Lanes visible;
        for (int i = 0; i < lane_count; ++i) {
          const auto lane = std::size_t(i);
          if (!group.active[i]) continue;
          const ShadedPoint point{group.position[lane], group.normal[lane]};
          visible[i] = march.march(point, direction[lane], xi, reach[i]).visibility;
        }
        return visible;
      };
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
