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

Lanes march_lanes(const DepthMarch& march, const PixelGroup& group, const Lanes3& direction,
                  float xi, const Lanes& reach) {
  Lanes visible;
  for (int i = 0; i < lane_count; ++i) {
    if (!group.active[i]) continue;
    visible[i] = march.march(group.point(i), at(direction, i), xi, reach[i]).visibility;
  }
  return visible;
}

/// Each lane's vector turned.
Lanes3 turned(const glm::mat3& rotation, const Lanes3& v) {
  Lanes3 result;
  for (int i = 0; i < lane_count; ++i) set_lane(result, i, rotation * at(v, i));
  return result;
}

/// The group of interleaved set `set` (0 to 15) in the block whose first pixel is `corner`.
PixelGroup pixel_group(const GBufferImages& surface, const SampleSet& samples, TurnPattern pattern,
                       glm::ivec2 corner, int set) {
  PixelGroup group;
  const glm::ivec2 set_place(set % 4, set / 4);
  for (int i = 0; i < lane_count; ++i) {
    const auto lane = std::size_t(i);
    const glm::ivec2 lane_place(i % 4, i / 4);
    const glm::ivec2 pixel =
        corner + (pattern == TurnPattern::interleaved ? set_place + 4 * lane_place
                                                      : 4 * set_place + lane_place);
    const bool inside = pixel.x < surface.mask.width() && pixel.y < surface.mask.height();
    glm::mat3 frame(1.0f);
    if (inside && surface.mask.at(pixel.x, pixel.y) > 0.5f) {
      group.active[i] = -1;
      group.any = true;
      group.pixel[lane] = pixel;
      group.position[lane] = vec3_at(surface.position_view, pixel);
      group.geometric_normal[lane] = vec3_at(surface.geometric_normal_view, pixel);
      frame = sampling_frame(vec3_at(surface.normal_view, pixel), samples.sets[std::size_t(set)]);
    }
    set_lane(group.frame.tangent, i, frame[0]);
    set_lane(group.frame.bitangent, i, frame[1]);
    set_lane(group.frame.normal, i, frame[2]);
  }
  return group;
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

void for_each_group(const GBufferImages& surface, const SampleSet& samples, TurnPattern pattern,
                    const std::function<void(const PixelGroup& group, int set)>& body) {
  constexpr int block_size = 16;
  const int columns = (surface.mask.width() + block_size - 1) / block_size;
  const int rows = (surface.mask.height() + block_size - 1) / block_size;
  parallel_for(std::size_t(columns) * std::size_t(rows), [&](std::size_t block) {
    throw_if_interrupted();
    const auto own_body = body;
    const glm::ivec2 corner = block_size * glm::ivec2(int(block) % columns, int(block) / columns);
    for (int set = 0; set < int(samples.sets.size()); ++set) {
      const PixelGroup group = pixel_group(surface, samples, pattern, corner, set);
      if (group.any) own_body(group, set);
    }
  });
}

GroupRays rays_of(const PixelGroup& group, const Lanes3& direction_view, const View& view,
                  float lift_world) {
  const glm::mat3 rotation = view.world_from_view_rotation();
  const glm::vec3 eye(view.camera.world_from_camera[3]);
  GroupRays rays{.origin = {}, .direction = turned(rotation, direction_view)};
  for (int i = 0; i < lane_count; ++i) {
    const auto lane = std::size_t(i);
    set_lane(rays.origin, i,
             eye + rotation * group.position[lane] +
                 lift_world * (rotation * group.geometric_normal[lane]));
  }
  return rays;
}

TracedRays::TracedRays(const TracedScene& traced, const View& view, const PassConstants& constants)
    : view_(view), lift_world_(traced.ray_lift_world()), visibility_(traced, constants.blocker) {}

void TracedRays::set_group(const PixelGroup& group, long directions) {
  const glm::mat3 rotation = view_.world_from_view_rotation();
  tile_.active = group.active;
  tile_.origin = rays_of(group, {}, view_, lift_world_).origin;
  tile_.tangent = turned(rotation, group.frame.tangent);
  tile_.bitangent = turned(rotation, group.frame.bitangent);
  tile_.normal = turned(rotation, group.frame.normal);
  visibility_.set_tile(tile_, CellKinds::tangent, directions);
}

Lanes TracedRays::toward(glm::vec3 direction_tangent, int cell) {
  return visibility_(tile_.active, out_of(tile_, direction_tangent), cell);
}

Lanes TracedRays::along(const PixelGroup& group, const Lanes3& direction_view, const Lanes& reach) {
  const GroupRays rays = rays_of(group, direction_view, view_, lift_world_);
  return visibility_.packets()(rays.origin, group.active, rays.direction, reach);
}

void VisibilitySource::set_group(const PixelGroup& group, long directions) {
  group_ = &group;
  if (auto* rays = std::get_if<TracedRays>(&source_)) rays->set_group(group, directions);
}

Lanes VisibilitySource::toward(glm::vec3 direction_tangent, int cell, float xi) {
  if (auto* rays = std::get_if<TracedRays>(&source_)) return rays->toward(direction_tangent, cell);
  return along(out_of(group_->frame, direction_tangent), xi, d_max_world_);
}

Lanes VisibilitySource::along(const Lanes3& direction_view, float xi, const Lanes& reach) {
  if (auto* rays = std::get_if<TracedRays>(&source_)) {
    return rays->along(*group_, direction_view, reach);
  }
  return march_lanes(std::get<DepthMarch>(source_), *group_, direction_view, xi, reach);
}

VisibilitySource depth_visibility(const GBufferImages& surface, const View& view,
                                  const PassConstants& constants) {
  return VisibilitySource(DepthMarch(surface, view, constants), constants.d_max_world);
}

VisibilitySource traced_visibility(const TracedScene& traced, const View& view,
                                   const PassConstants& constants) {
  return VisibilitySource(TracedRays(traced, view, constants));
}

}  // namespace occlab
