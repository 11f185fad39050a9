#include "renderers/methods/visibility_source.h"

#include <algorithm>

#include "renderers/methods/frame.h"
#include "renderers/scene/interrupt.h"
#include "renderers/scene/parallel.h"
#include "renderers/shared/frame.h"
#include "renderers/shared/visibility.h"

namespace occlab {
namespace {

glm::vec3 vec3_at(const Image& image, glm::ivec2 pixel) {
  return {image.at(pixel.x, pixel.y, 0), image.at(pixel.x, pixel.y, 1),
          image.at(pixel.x, pixel.y, 2)};
}

/// As the shaders fetch it: w is 0 where no surface is seen.
glm::vec4 surface_at(const GBufferImages& images, glm::ivec2 pixel) {
  return {vec3_at(images.position_view, pixel), images.mask.at(pixel.x, pixel.y)};
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

DepthMarch::DepthMarch(const GBufferImages& surface, const HiddenImages* hidden, const View& view,
                       const PassConstants& constants)
    : surface_(surface),
      hidden_(hidden),
      constants_(constants),
      image_center_(0.5f * glm::vec2(view.width, view.height)),
      focal_pixels_(view.focal_pixels()) {}

std::optional<glm::ivec2> DepthMarch::pixel_of(glm::vec3 q) const {
  const glm::vec2 pixel = project_to_pixel(q, image_center_, focal_pixels_);
  if (!on_screen(q, pixel, image_center_)) return std::nullopt;
  return glm::ivec2(pixel);
}

Blocker DepthMarch::nearer(const Blocker& best, glm::vec4 surface, int source, glm::ivec2 pixel,
                           const ShadedPoint& point) const {
  return nearer_blocker(best, surface, source, pixel, point.position, point.normal,
                        constants_.epsilon_world, constants_.d_max_world);
}

/// blocker_at() of hidden_march.glsl with layers.
Blocker DepthMarch::behind_pairs(const ShadedPoint& point, glm::vec3 q) const {
  Blocker blocker = no_blocker();
  const std::optional<glm::ivec2> pixel = pixel_of(q);
  if (!pixel) return blocker;
  const auto layer = [&](std::size_t i) {
    return i < hidden_->images.size() ? surface_at(hidden_->images[i], *pixel) : glm::vec4(0.0f);
  };
  glm::vec4 front = surface_at(surface_, *pixel);
  for (std::size_t i = 0; i <= hidden_->images.size(); i += 2) {
    const glm::vec4 back = layer(i);
    if (between_pair(front, back, q, constants_.bias_world)) {
      blocker = nearer(blocker, front, int(i), *pixel, point);
      blocker = nearer(blocker, back, int(i) + 1, *pixel, point);
    }
    front = layer(i + 1);
  }
  return blocker;
}

/// The same with cameras.
Blocker DepthMarch::behind_cameras(const ShadedPoint& point, glm::vec3 q) const {
  Blocker blocker = no_blocker();
  const float bias = constants_.bias_world;
  if (const std::optional<glm::ivec2> pixel = pixel_of(q)) {
    const glm::vec4 surface = surface_at(surface_, *pixel);
    if (in_the_open(surface.w, surface.z, q.z, bias)) return no_blocker();
    blocker = nearer(blocker, surface, 0, *pixel, point);
  }
  for (std::size_t i = 0; i < hidden_->cameras.size(); ++i) {
    const View& view = hidden_->cameras[i].view;
    const glm::mat4& m = hidden_->cameras[i].camera_from_view;
    const glm::vec2 center = 0.5f * glm::vec2(view.width, view.height);
    const glm::vec3 there = in_camera(m[0], m[1], m[2], m[3], q);
    const glm::vec2 place = project_to_pixel(there, center, view.focal_pixels());
    if (!on_screen(there, place, center)) continue;
    const glm::ivec2 pixel(place);
    const glm::vec4 surface = surface_at(hidden_->images[i], pixel);
    if (seen_from_back(surface.w)) continue;
    const float z = in_camera(m[0], m[1], m[2], m[3], glm::vec3(surface)).z;
    if (in_the_open(surface.w, z, there.z, bias)) return no_blocker();
    blocker = nearer(blocker, surface, int(i) + 1, pixel, point);
  }
  return blocker;
}

Blocker DepthMarch::blocker_at(const ShadedPoint& point, glm::vec3 q) const {
  if (hidden_) {
    return hidden_->cameras.empty() ? behind_pairs(point, q) : behind_cameras(point, q);
  }
  Blocker blocker = no_blocker();
  const std::optional<glm::ivec2> pixel = pixel_of(q);
  if (!pixel) return blocker;
  const glm::vec4 surface = surface_at(surface_, *pixel);
  if (surface_blocks(surface, q, point.position, point.normal, constants_.bias_world,
                     constants_.epsilon_world, constants_.d_max_world)) {
    blocker.to_surface = glm::vec3(surface) - point.position;
    blocker.distance = dot(blocker.to_surface, blocker.to_surface);
    blocker.pixel = *pixel;
  }
  return blocker;
}

DepthMarch::Result DepthMarch::march(const ShadedPoint& point, glm::vec3 direction, float xi,
                                     float reach, int first_step) const {
  for (int k = first_step; k < constants_.steps; ++k) {
    const glm::vec3 q = march_point(point.position, direction, reach, k, xi, constants_.steps);
    const Blocker found = blocker_at(point, q);
    if (found.distance < 0.0f) continue;
    const BlockerWeight& blocker = constants_.blocker;
    const float visibility =
        blocked_visibility(blocker.weight, sqrt(found.distance), blocker.d_max_world,
                           blocker.lambda_per_world, blocker.fade_start);
    return {visibility, true, k, q, found.pixel, found.source, found.to_surface};
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
                                  const PassConstants& constants, const HiddenImages* hidden) {
  return VisibilitySource(DepthMarch(surface, hidden, view, constants), constants.d_max_world);
}

DepthMarch depth_march(const Frame& frame, const ParameterSet& parameters) {
  const std::optional<HiddenSettings> settings = hidden_settings(parameters);
  return {frame.surface(gbuffer_bits(parameters)),
          settings ? &frame.hidden_images(*settings) : nullptr, frame.view,
          pass_constants(parameters)};
}

VisibilitySource visibility_source(const Frame& frame, const ParameterSet& parameters) {
  const PassConstants constants = pass_constants(parameters);
  if (traces(parameters)) return traced_visibility(frame.traced(), frame.view, constants);
  return VisibilitySource(depth_march(frame, parameters), constants.d_max_world);
}

VisibilitySource traced_visibility(const TracedScene& traced, const View& view,
                                   const PassConstants& constants) {
  return VisibilitySource(TracedRays(traced, view, constants));
}

}  // namespace occlab
