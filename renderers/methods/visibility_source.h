#pragma once

#include <array>
#include <functional>
#include <glm/glm.hpp>

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

inline constexpr int group_block = 16;  ///< pixels of the block a side

/// The group of interleaved set `set` (0 to 15) in the block whose first pixel is `corner`.
PixelGroup pixel_group(const GBufferImages& surface, const SampleSet& samples, glm::ivec2 corner,
                       int set);

using LaneDirections = std::array<glm::vec3, lane_count>;

/// V of one unit direction a lane, view space. Blockers count within `reach` (and d_max); `xi` is
/// the march offset. What inactive lanes get does not matter.
using VisibilitySource = std::function<Lanes(
    const PixelGroup& group, const LaneDirections& direction, float xi, const Lanes& reach)>;

/// The march through the depth buffer, from the header that the shaders include. `surface` outlives
/// the result.
VisibilitySource depth_visibility(const GBufferImages& surface, const View& view,
                                  const PassConstants& constants);

/// Rays through the whole scene, from the lifted points that the reference starts at. `traced`
/// outlives the result.
VisibilitySource traced_visibility(const TracedScene& traced, const View& view,
                                   const PassConstants& constants);

}  // namespace occlab
