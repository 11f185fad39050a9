#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderers/trace/packet.h"
#include "renderers/trace/triangle_tree.h"

namespace occlab {

/// The rays of a tile in 5 dimensions, after Arvo and Kirk 1987, "Fast Ray Tracing by Ray
/// Classification": 16 neighbouring origins, directions in cells, and for each cell the list of all
/// that any ray of the cell can meet: single triangles that are near, and subtrees that are seen
/// within a small angle. Near a flat wall most lists are empty, and their rays are known without
/// being traced; the others begin far down the tree, in the few parts that matter to them.

/// Cells of directions in the tangent frame of each pixel, by its cosine-mapping: u = sin^2 theta,
/// v = phi / 2 pi.
inline constexpr int tangent_rings = 8;
inline constexpr int tangent_sectors = 16;
inline constexpr int tangent_cells = tangent_rings * tangent_sectors;
/// Cells of directions in world space: the faces of a cube, each a grid.
inline constexpr int cube_cells_across = 4;
inline constexpr int cube_cells = 6 * cube_cells_across * cube_cells_across;
inline constexpr int direction_cells = tangent_cells + cube_cells;

/// The cell of a direction in the tangent frames of the pixels; u, v in [0, 1).
inline int tangent_cell(float u, float v) {
  return int(u * tangent_rings) * tangent_sectors + int(v * tangent_sectors);
}
int tangent_cell(const glm::vec3& direction_tangent);
/// The cell of a direction that all pixels share.
int cube_cell(const glm::vec3& direction_world);

/// Cones that hold the cells' directions: axis, cosine and sine of the angle.
struct alignas(32) DirectionCones {
  std::array<float, direction_cells> x, y, z, cosine, sine;
};

/// The pixels of a tile, world space.
struct TileFrame : LaneFrames {
  LaneMask active;  ///< at least one
  Lanes3 origin;
};

enum class CellKinds { tangent, cube, both };

class TileCandidates {
 public:
  /// A triangle of the tree, or all that is below a node.
  struct Entry {
    std::uint32_t index : 31;
    std::uint32_t node : 1;
  };
  /// With more, Embree is faster.
  static constexpr int list_capacity = 64;
  struct List {
    bool many;  ///< too many, or not known: not listed
    int count;
    const Entry* entries;
  };

  explicit TileCandidates(const TriangleTree& tree);

  /// Lists what rays of at most `reach` scene units from the tile can meet in the pixels' upper
  /// hemispheres. `tolerance`, scene units: a triangle less than this below the pixels' horizons is
  /// listed. `kinds`: the cells that will be asked for. Looks at no more than `budget` nodes of the
  /// tree; what is then left is `many`.
  void fill(const TileFrame& tile, float reach, float tolerance, CellKinds kinds, int budget);

  List list(int cell) const {
    const auto c = std::size_t(cell);
    return {(many_[c / 64] >> (c % 64) & 1) != 0, counts_[c], &lists_[c * list_capacity]};
  }

 private:
  static constexpr int words = (direction_cells + 63) / 64;
  using CellMask = std::array<std::uint64_t, words>;
  /// Directions within an angle of an axis.
  struct Cap {
    glm::vec3 axis{0.0f};
    float cosine = -100.0f;  ///< below -1: all directions
    float sine = 0.0f;
  };

  bool set_tile(const TileFrame& tile, float reach, float tolerance);
  template <typename... Caps>
  void restrict(CellMask& mask, const Caps&... caps) const;
  bool below_horizon(const glm::vec3& offset, float extent) const;
  Cap cap_of_ball(const glm::vec3& offset, float distance, float radius) const;
  void visit(std::uint32_t index, CellMask mask);
  void add_triangle(std::uint32_t index, CellMask mask);
  void list(Entry entry, CellMask mask);
  void mark_many(const CellMask& mask);
  bool open(CellMask& mask) const;
  int count(const CellMask& mask) const;
  CellMask cells_above_horizon() const;

  const TriangleTree& tree_;
  glm::vec3 scene_center_;
  float scene_radius_;
  const DirectionCones* local_;  ///< the tangent cells in the tangent frame, those of the cube
  DirectionCones world_;         ///< in world space, wide enough for all pixels
  CellMask many_{};
  std::size_t first_cell_ = 0;  ///< of the kinds that are asked for
  std::size_t last_cell_ = direction_cells;
  std::array<int, direction_cells> counts_{};
  std::vector<Entry> lists_;
  struct Visit {
    std::uint32_t node;
    CellMask mask;
  };
  std::vector<Visit> stack_;
  // The tile: a ball of origins, the horizon of its pixels.
  glm::vec3 center_{0.0f};
  float radius_ = 0.0f;
  float reach_ = 0.0f;
  glm::vec3 normal_{0.0f};
  float spread_ = 0.0f;   ///< largest distance of a pixel's normal from it
  float horizon_ = 0.0f;  ///< x is above no pixel's horizon if dot(x - center, normal) < -horizon
};

}  // namespace occlab
