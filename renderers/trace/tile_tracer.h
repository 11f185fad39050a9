#pragma once

#include <array>

#include "renderers/scene/view.h"
#include "renderers/trace/probe_table.h"
#include "renderers/trace/reference.h"
#include "renderers/trace/tile_visibility.h"

namespace occlab {

inline constexpr int tile_size = 4;  ///< pixels across
static_assert(tile_size * tile_size == lane_count);

/// The points of a tile, world space, origins lifted off the surface; inactive lanes hold harmless
/// values.
struct Tile : TileFrame {
  bool any = false;  ///< lane is active
  std::array<glm::vec3, lane_count> position{};
  std::array<glm::vec3, lane_count> albedo{};
};

/// The tile whose top left pixel is (x0, y0).
Tile load_tile(const SurfacePoints& points, const View& view, int x0, int y0, float lift_world);

/// Sums of a few hundred rays for the 16 pixels.
struct RaySums {
  __m128 light[lane_count] = {};  ///< of L v cos / pdf, RGB; the fourth is without meaning
  Lanes visibility;               ///< of v over cosine-distributed directions
};

/// Traces rays from the pixels of one tile after the other. One for each thread.
class TileTracer {
 public:
  /// `other_density_share`: samples of the other strategy for each of one; the densities add up in
  /// the balance heuristic [Veach 1997].
  TileTracer(const TracedScene& traced, const TraceSettings& settings, const ProbeTable& table,
             const EnvironmentSampler& sampler, float other_density_share)
      : visibility_(traced, {settings.weight, settings.d_max_world, settings.lambda_per_world,
                             settings.fade_start}),
        settings_(settings),
        table_(table),
        sampler_(sampler),
        other_density_share_(other_density_share) {}

  /// `tile` must stay until the next. `rays` of each strategy will be added for each point.
  void set_tile(const Tile& tile, CellKinds strategies, long rays) {
    tile_ = &tile;
    visibility_.set_tile(tile, strategies, rays);
  }

  /// One direction of density cos/pi about each pixel's normal, from u, v in [0, 1).
  void add_cosine(float u, float v, RaySums& sums);
  /// One direction in proportion to the probe's texels, the same for the whole tile.
  void add_environment(float u, float v, RaySums& sums);
  /// Irradiance of a punctual light at each pixel, shadowed by one ray.
  void add_light(const Light& light, std::array<glm::vec3, lane_count>& sum);

 private:
  TileVisibility visibility_;
  const TraceSettings& settings_;
  const ProbeTable& table_;
  const EnvironmentSampler& sampler_;
  float other_density_share_;
  const Tile* tile_ = nullptr;
};

}  // namespace occlab
