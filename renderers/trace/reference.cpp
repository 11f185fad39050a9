#include "renderers/trace/reference.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <glm/gtc/constants.hpp>

#include "renderers/scene/interrupt.h"
#include "renderers/scene/parallel.h"
#include "renderers/trace/bounce_tracer.h"
#include "renderers/trace/point_sequence.h"
#include "renderers/trace/tile_tracer.h"

namespace occlab {
namespace {

/// Sums of one batch. Doubles: floats would drift by 3e-4 of the result at a million rays.
struct BatchSums {
  std::array<glm::dvec3, lane_count> light{};
  std::array<double, lane_count> visibility{};

  void add(const RaySums& rays) {
    for (int i = 0; i < lane_count; ++i) {
      const auto lane = std::size_t(i);
      light[lane] += glm::dvec3(rays.light[lane][0], rays.light[lane][1], rays.light[lane][2]);
      visibility[lane] += double(rays.visibility[i]);
    }
  }
};
constexpr long rays_per_sum = 256;

/// Running mean and sum of squared deviations of the batches [Welford 1962], one RGB a lane.
struct BatchStatistics {
  std::array<glm::dvec3, lane_count> mean{};
  std::array<glm::dvec3, lane_count> squares{};
  std::array<double, lane_count> visibility{};

  std::array<glm::dvec3, lane_count> indirect{};  ///< the bounce's part of the sum

  void add(std::size_t lane, long count, glm::dvec3 value) {
    const glm::dvec3 delta = value - mean[lane];
    mean[lane] += delta / double(count);
    squares[lane] += delta * (value - mean[lane]);
  }
};

}  // namespace

Reference trace_reference(const TracedScene& traced, const Environment& environment,
                          std::span<const Light> lights, const View& view,
                          const SurfacePoints& points, const TraceSettings& settings) {
  const EnvironmentSampler sampler(environment);
  const ProbeTable table(environment, sampler);
  const bool use_cosine = settings.estimator != Estimator::environment;
  // A black probe has no texel to draw.
  const bool use_environment = settings.estimator != Estimator::cosine && !sampler.black();
  const long strategies = long(use_cosine) + long(use_environment);
  const long per_round = reference_batches * std::max(1L, strategies);
  const long per_batch = std::max(1L, (settings.rays_per_pixel + per_round - 1) / per_round);
  const CellKinds kinds = strategies == 2 ? CellKinds::both
                          : use_cosine    ? CellKinds::tangent
                                          : CellKinds::cube;
  // Balance heuristic with as many samples of either strategy: the densities add [Veach 1997].
  const float other_share = strategies == 2 ? 1.0f : 0.0f;

  Reference result;
  result.radiance = Image(view.width, view.height, 3);
  result.radiance_variance = Image(view.width, view.height, 3);
  if (use_cosine) result.ambient_occlusion = Image(view.width, view.height, 1);
  if (settings.bounce) result.radiance_indirect = Image(view.width, view.height, 3);
  result.rays_per_pixel = per_batch * strategies * reference_batches;

  const int tiles_x = (view.width + tile_size - 1) / tile_size;
  const int tiles_y = (view.height + tile_size - 1) / tile_size;
  std::atomic<std::uint64_t> pixels_traced{0};
  std::atomic<std::uint64_t> bounce_rays{0};

  parallel_for(std::size_t(tiles_y), [&](std::size_t tile_row) {
    throw_if_interrupted();
    TileTracer tracer(traced, settings, table, sampler, other_share);
    std::optional<BounceTracer> bounce;
    if (settings.bounce) bounce.emplace(traced, settings, table, sampler, lights);
    for (int tile_column = 0; tile_column < tiles_x; ++tile_column) {
      const int x0 = tile_column * tile_size;
      const int y0 = int(tile_row) * tile_size;
      const Tile tile = load_tile(points, view, x0, y0, traced.ray_lift_world());
      if (!tile.any) continue;
      tracer.set_tile(tile, kinds, per_batch * reference_batches);
      if (bounce) bounce->set_tile(tile, per_batch * reference_batches);
      const auto tile_id = std::uint32_t(int(tile_row) * tiles_x + tile_column);

      BatchStatistics statistics;
      for (long batch = 0; batch < reference_batches; ++batch) {
        BatchSums sums;
        PointSequence cosine_points(settings.seed, tile_id, std::uint32_t(batch), 0);
        PointSequence environment_points(settings.seed, tile_id, std::uint32_t(batch), 1);
        for (long first = 0; first < per_batch; first += rays_per_sum) {
          RaySums rays;
          for (long i = first; i < std::min(first + rays_per_sum, per_batch); ++i) {
            if (use_cosine) {
              const auto [u, v] = cosine_points.next();
              tracer.add_cosine(u, v, rays);
            }
            if (use_environment) {
              const auto [u, v] = environment_points.next();
              tracer.add_environment(u, v, rays);
            }
          }
          sums.add(rays);
        }
        BatchSums bounced;
        if (bounce) {
          PointSequence bounce_points(settings.seed, tile_id, std::uint32_t(batch), 2);
          RandomPoints sender_points(settings.seed, tile_id, std::uint32_t(batch), 3);
          for (long first = 0; first < per_batch; first += rays_per_sum) {
            RaySums rays;
            for (long i = first; i < std::min(first + rays_per_sum, per_batch); ++i) {
              const auto [u, v] = bounce_points.next();
              bounce->add(u, v, sender_points, rays);
            }
            bounced.add(rays);
          }
        }
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
          const glm::dvec3 indirect = bounced.light[lane] / double(per_batch);
          statistics.add(lane, batch + 1, sums.light[lane] / double(per_batch) + indirect);
          statistics.indirect[lane] += indirect / double(reference_batches);
          statistics.visibility[lane] += sums.visibility[lane] / double(per_batch);
        }
      }

      std::array<glm::vec3, lane_count> from_lights{};
      for (const Light& light : lights) tracer.add_light(light, from_lights);

      for (int i = 0; i < lane_count; ++i) {
        if (!tile.active[i]) continue;
        const auto lane = std::size_t(i);
        const int x = x0 + i % tile_size;
        const int y = y0 + i / tile_size;
        const glm::dvec3 brdf = glm::dvec3(tile.albedo[lane]) / glm::pi<double>();
        const glm::dvec3 radiance = brdf * (statistics.mean[lane] + glm::dvec3(from_lights[lane]));
        const glm::dvec3 variance = brdf * brdf * statistics.squares[lane] /
                                    double(reference_batches * (reference_batches - 1));
        for (int c = 0; c < 3; ++c) {
          result.radiance.at(x, y, c) = float(radiance[c]);
          result.radiance_variance.at(x, y, c) = float(variance[c]);
          if (bounce) {
            result.radiance_indirect.at(x, y, c) = float(brdf[c] * statistics.indirect[lane][c]);
          }
        }
        if (use_cosine) {
          result.ambient_occlusion.at(x, y) =
              float(statistics.visibility[lane] / double(reference_batches));
        }
        ++pixels_traced;
      }
    }
    if (bounce) bounce_rays += bounce->rays();
  });
  result.rays =
      bounce_rays + pixels_traced * std::uint64_t(result.rays_per_pixel + long(lights.size()));
  return result;
}

}  // namespace occlab
