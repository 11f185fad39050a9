#pragma once

#include <algorithm>

#include "renderers/trace/packet_visibility.h"
#include "renderers/trace/tile_candidates.h"

namespace occlab {

/// Visibility of many rays from the same 16 points: what they can meet is listed once for each cell
/// of directions, and only where that is much does Embree trace. The answers are those of
/// PacketVisibility, but for rays within rounding of a triangle's edge. One for each thread; the
/// scene must outlive it.
class TileVisibility {
 public:
  TileVisibility(const TracedScene& traced, const BlockerWeight& weight)
      : candidates_(traced.tree()),
        tree_(traced.tree()),
        packets_(traced, weight),
        weight_(weight),
        tolerance_(0.1f * traced.ray_lift_world()) {
    reach_.v.fill(weight.d_max_world);
  }

  /// Goes to a tile, which must stay until the next. `rays`: how many each point will ask for; what
  /// listing may cost goes by it.
  void set_tile(const TileFrame& tile, CellKinds kinds, long rays) {
    tile_ = &tile;
    const long budget = std::min(visits_per_ray * rays, max_visits);
    candidates_.fill(tile, weight_.d_max_world, tolerance_, kinds, int(budget));
  }

  /// v in [0, 1] of each active lane, over the distance d_max, as PacketVisibility has it. `cell`
  /// is the tangent_cell() of the direction that the lanes share in their tangent frames, or the
  /// cube_cell() of the one that they share in the world; every direction is above its pixel's
  /// horizon.
  Lanes operator()(const LaneMask& active, const Lanes3& direction, int cell) {
    const TileCandidates::List list = candidates_.list(cell);
    if (list.many) return packets_(tile_->origin, active, direction, reach_);
    if (list.count > 0) return test(active, direction, list);
    Lanes visible;
    visible.v.fill(1.0f);
    return visible;
  }

  /// For rays that are not of a cell.
  PacketVisibility& packets() { return packets_; }

 private:
  // Measured: with more visits, lists cost more than they save.
  static constexpr long visits_per_ray = 4;
  static constexpr long max_visits = 8192;

  Lanes test(const LaneMask& active, const Lanes3& direction,
             const TileCandidates::List& list) const;

  Lanes reach_;
  TileCandidates candidates_;
  const TriangleTree& tree_;
  PacketVisibility packets_;
  BlockerWeight weight_;
  float tolerance_;
  const TileFrame* tile_ = nullptr;
};

}  // namespace occlab
