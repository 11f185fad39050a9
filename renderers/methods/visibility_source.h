#pragma once

#include <array>
#include <functional>
#include <glm/glm.hpp>
#include <optional>
#include <variant>

#include "renderers/gl/hidden_surfaces.h"
#include "renderers/methods/pass_constants.h"
#include "renderers/methods/sample_set.h"
#include "renderers/shared/march.h"
#include "renderers/trace/packet.h"
#include "renderers/trace/tile_visibility.h"
#include "renderers/trace/traced_scene.h"

namespace occlab {

struct ShadedPoint {
  glm::vec3 position;  ///< view space
  glm::vec3 normal;    ///< view space, unit
};

/// 16 pixels that one of the 16 turns of the sample set is for: a direction of the set is the same
/// one in all their turned tangent frames. View space; inactive lanes show no surface.
struct PixelGroup {
  std::array<glm::ivec2, lane_count> pixel{};
  LaneMask active;
  bool any = false;
  std::array<glm::vec3, lane_count> position{};
  std::array<glm::vec3, lane_count> geometric_normal{};
  LaneFrames frame;  ///< turned tangent, bitangent, normal

  ShadedPoint point(int lane) const {
    return {position[std::size_t(lane)], at(frame.normal, lane)};
  }
};

/// Which pixels have a turn in common.
enum class TurnPattern {
  interleaved,  ///< every fourth each way, as in the shaders
  tiles,        ///< 4x4 neighbours, whose rays travel together
};

/// Calls body(group, set) for every group of the image that shows any surface, on all threads.
/// `body` is copied for every block of 16x16 pixels: what it holds by value is one thread's. Throws
/// Interrupted.
void for_each_group(const GBufferImages& surface, const SampleSet& samples, TurnPattern pattern,
                    const std::function<void(const PixelGroup& group, int set)>& body);

/// screen_space.glsl's march through the depth buffer, from the header that the shaders include.
class DepthMarch {
 public:
  /// Through the first surfaces, and through the hidden ones where there are any. Both outlive
  /// this.
  DepthMarch(const GBufferImages& surface, const HiddenImages* hidden, const View& view,
             const PassConstants& constants);

  struct Result {
    float visibility = 1.0f;
    bool blocked = false;
    int step = 0;        ///< of the march's point that was found blocked
    glm::vec3 sample{};  ///< view space: that point
    glm::ivec2 pixel{};  ///< whose surface blocks it
    /// What shows that surface: 0 for the first surfaces, i + 1 for hidden image i.
    int source = 0;
    glm::vec3 to_surface{};  ///< view space, from the point to it
  };
  /// The first blocker of steps `first_step` and later.
  Result march(const ShadedPoint& point, glm::vec3 direction, float xi, float reach,
               int first_step = 0) const;

  /// The pixel that a view-space point projects into, if it is in front of the camera and on the
  /// screen.
  std::optional<glm::ivec2> pixel_of(glm::vec3 q) const;

 private:
  Blocker blocker_at(const ShadedPoint& point, glm::vec3 q) const;
  Blocker behind_pairs(const ShadedPoint& point, glm::vec3 q) const;
  Blocker behind_cameras(const ShadedPoint& point, glm::vec3 q) const;
  Blocker nearer(const Blocker& best, glm::vec4 surface, int source, glm::ivec2 pixel,
                 const ShadedPoint& point) const;

  const GBufferImages& surface_;
  const HiddenImages* hidden_;
  PassConstants constants_;
  glm::vec2 image_center_;
  float focal_pixels_;
};

/// A ray a lane, world space, from `lift_world` above the surface along its geometric normal.
struct GroupRays {
  Lanes3 origin;
  Lanes3 direction;
};
GroupRays rays_of(const PixelGroup& group, const Lanes3& direction_view, const View& view,
                  float lift_world);

/// Rays through the whole scene, from the lifted points that the reference starts at.
class TracedRays {
 public:
  /// `traced` outlives this.
  TracedRays(const TracedScene& traced, const View& view, const PassConstants& constants);

  void set_group(const PixelGroup& group, long directions);
  Lanes toward(glm::vec3 direction_tangent, int cell);
  Lanes along(const PixelGroup& group, const Lanes3& direction_view, const Lanes& reach);

 private:
  View view_;
  float lift_world_;
  TileFrame tile_;
  TileVisibility visibility_;
};

/// V of a group's pixels, from the depth buffer or from rays. Every thread has its own copy.
class VisibilitySource {
 public:
  explicit VisibilitySource(DepthMarch march, float d_max_world) : source_(std::move(march)) {
    d_max_world_.v.fill(d_max_world);
  }
  explicit VisibilitySource(TracedRays rays) : source_(std::move(rays)) {}

  /// Goes to a group, which must stay until the next. `directions`: how many toward() will be asked
  /// for.
  void set_group(const PixelGroup& group, long directions);
  /// V in one unit direction of the group's frames; `cell` is its tangent_cell(). Blockers count
  /// within d_max; `xi` is the march offset. What inactive lanes get does not matter.
  Lanes toward(glm::vec3 direction_tangent, int cell, float xi);
  /// V in a unit direction a lane, view space. Blockers count within `reach`, which is at most
  /// d_max.
  Lanes along(const Lanes3& direction_view, float xi, const Lanes& reach);

 private:
  std::variant<DepthMarch, TracedRays> source_;
  Lanes d_max_world_;
  const PixelGroup* group_ = nullptr;
};

/// The march of the passes. `surface` and `hidden`, which may be null, outlive the result.
VisibilitySource depth_visibility(const GBufferImages& surface, const View& view,
                                  const PassConstants& constants,
                                  const HiddenImages* hidden = nullptr);

/// Rays. `traced` outlives the result.
VisibilitySource traced_visibility(const TracedScene& traced, const View& view,
                                   const PassConstants& constants);

struct Frame;

/// What the parameters' `visibility` asks for. The frame outlives the result.
VisibilitySource visibility_source(const Frame& frame, const ParameterSet& parameters);

/// Their march, whether or not they trace rays instead. The frame outlives the result.
DepthMarch depth_march(const Frame& frame, const ParameterSet& parameters);

}  // namespace occlab
