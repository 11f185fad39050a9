#pragma once

#include <span>
#include <string>
#include <vector>

#include "renderers/methods/frame.h"
#include "renderers/scene/image_io.h"

namespace occlab {

/// Depth layers of a view against those of closed solids, which triangles enter from their fronts
/// and leave through their backs.
struct LayerSides {
  /// Pixels whose layers leave what they have not entered, or end inside: of open meshes, of
  /// triangles that are clockwise from outside, or of a solid that the camera is in. Where nothing
  /// lies behind an entered surface, all that is behind it counts as solid, as with a single layer.
  std::size_t open_mesh_pixels = 0;
  /// Pixels whose layers are those of closed solids, but whose pairs are not a front and a back:
  /// of solids that reach into one another.
  std::size_t overlapping_pixels = 0;
  /// Pixels of which every layer shows a surface: there may be more behind.
  std::size_t full_pixels = 0;
};

/// `sides`: 1 (front), 2 (back) or 0 (no surface) of every layer, the first one first.
LayerSides count_sides(std::span<const Image> sides);

/// What the hidden surfaces of a view turned out to be, by name, and what that does. Layers:
/// `open_mesh_pixels`, `overlapping_solid_pixels`, `full_layer_pixels`. Cameras: `cameras_blind`,
/// how many see no surface; `camera_surface_share`, the share of each one's pixels that show a
/// surface; `camera_back_share`, the share of those that show it from its back, which is 0 outside
/// of closed solids: such pixels tell the march nothing.
void add_hidden_facts(const Frame& frame, const HiddenSettings& settings, Metadata& facts);

}  // namespace occlab
