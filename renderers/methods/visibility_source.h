#pragma once

#include <array>
#include <functional>
#include <glm/glm.hpp>
#include <optional>

#include "renderers/gl/gbuffer.h"
#include "renderers/methods/pass_constants.h"
#include "renderers/methods/sample_set.h"
#include "renderers/trace/packet.h"
#include "renderers/trace/traced_scene.h"

namespace occlab {

/// 16 pixels of one interleaved set, every fourth of a 16x16 block each way: a direction of the
/// sample set is the same one in all their turned tangent frames, so that rays travel together.
/// View space; inactive lanes show no surface.
struct PixelGroup {
  std::array<glm::ivec2, lane_count> pixel{};
  LaneMask active;
  bool any = false;
  std::array<glm::vec3, lane_count> position{};
  std::array<glm::vec3, lane_count> normal{};
  std::array<glm::vec3, lane_count> geometric_normal{};
  std::array<glm::mat3, lane_count> frame{};  ///< columns: turned tangent, bitangent, normal
};

/// The group of interleaved set `set` (0 to 15) in the block whose first pixel is `corner`.
PixelGroup pixel_group(const GBufferImages& surface, const SampleSet& samples, glm::ivec2 corner,
                       int set);

/// Calls body(group, set) for every group of the image that shows any surface, on all threads.
/// Throws Interrupted.
void for_each_group(const GBufferImages& surface, const SampleSet& samples,
                    const std::function<void(const PixelGroup& group, int set)>& body);

using LaneDirections = std::array<glm::vec3, lane_count>;

struct ShadedPoint {
  glm::vec3 position;  ///< view space
  glm::vec3 normal;    ///< view space, unit
};

/// V of one unit direction a lane, view space. Blockers count within `reach` (and d_max); `xi` is
/// the march offset. What inactive lanes get does not matter.
using VisibilitySource = std::function<Lanes(
    const PixelGroup& group, const LaneDirections& direction, float xi, const Lanes& reach)>;

/// screen_space.glsl's march through the depth buffer, from the header that the shaders include.
class DepthMarch {
 public:
  /// `surface` outlives this.
  DepthMarch(const GBufferImages& surface, const View& view, const PassConstants& constants);

  struct Result {
    float visibility = 1.0f;
    bool blocked = false;
    int step = 0;        ///< of the march's point that was found blocked
    glm::vec3 sample{};  ///< view space: that point
    glm::ivec2 pixel{};  ///< whose surface blocks it
  };
  /// The first blocker of steps `first_step` and later.
  Result march(const ShadedPoint& point, glm::vec3 direction, float xi, float reach,
               int first_step = 0) const;

  /// The pixel that a view-space point projects into, if it is in front of the camera and on the
  /// screen.
  std::optional<glm::ivec2> pixel_of(glm::vec3 q) const;

 private:
  const GBufferImages& surface_;
  PassConstants constants_;
  glm::vec2 image_center_;
  float focal_pixels_;
};

/// DepthMarch of each lane. `surface` outlives the result.
VisibilitySource depth_visibility(const GBufferImages& surface, const View& view,
                                  const PassConstants& constants);

/// A ray a lane, world space, from `lift_world` above the surface along its geometric normal.
struct GroupRays {
  Lanes3 origin;
  Lanes3 direction;
};
GroupRays rays_of(const PixelGroup& group, const LaneDirections& direction, const View& view,
                  float lift_world);

/// Rays through the whole scene, from the lifted points that the reference starts at. `traced`
/// outlives the result.
VisibilitySource traced_visibility(const TracedScene& traced, const View& view,
                                   const PassConstants& constants);

}  // namespace occlab
