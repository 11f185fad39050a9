#pragma once

#include <optional>
#include <span>

#include "renderers/scene/punctual.h"
#include "renderers/trace/point_sequence.h"
#include "renderers/trace/surface_rays.h"
#include "renderers/trace/tile_tracer.h"

namespace occlab {

/// One bounce at the pixels of one tile after the other. One for each thread.
class BounceTracer {
 public:
  /// `settings` has a bounce; all outlive this.
  BounceTracer(const TracedScene& traced, const TraceSettings& settings, const ProbeTable& table,
               const EnvironmentSampler& sampler, std::span<const Light> lights);

  /// `tile` must stay until the next. `rays`: how many will be added for each point.
  void set_tile(const Tile& tile, long rays);

  /// One direction of density cos/pi about each pixel's normal, from u, v in [0, 1): adds
  /// pi (1 - v) L_o of what it meets to the light. `points` are for the light there.
  void add(float u, float v, RandomPoints& points, RaySums& sums);

  /// Traced so far, for all pixels.
  std::uint64_t rays() const { return rays_; }

 private:
  /// 16 senders, with the frames that their light is sampled in.
  struct SenderTile : TileFrame {
    std::array<glm::vec3, lane_count> position{};
    std::array<glm::vec3, lane_count> albedo{};
    std::array<glm::vec3, lane_count> irradiance{};
  };
  SenderTile senders(const SurfaceRays::Hits& hits) const;
  void add_cosine_sample(float u, float v, SenderTile& tile);
  void add_environment_sample(float u, float v, SenderTile& tile);
  void add_lights(SenderTile& tile);
  /// Of the light that senders get: 1 where nothing may block it.
  Lanes visible(const SenderTile& tile, const LaneMask& active, const Lanes3& direction,
                const Lanes& distance);

  TileVisibility visibility_;  ///< of the pixels
  Lanes reach_;
  SurfaceRays surfaces_;
  std::vector<PunctualLight> lights_;
  const TraceSettings& settings_;
  const ProbeTable& table_;
  const EnvironmentSampler& sampler_;
  std::uint64_t rays_ = 0;
  const Tile* tile_ = nullptr;
  float lift_world_;
};

}  // namespace occlab
