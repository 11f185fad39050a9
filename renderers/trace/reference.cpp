#include "renderers/trace/reference.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <glm/gtc/constants.hpp>

#include "renderers/scene/interrupt.h"
#include "renderers/scene/parallel.h"
#include "renderers/scene/punctual.h"
#include "renderers/shared/equirect.h"
#include "renderers/shared/frame.h"
#include "renderers/shared/lights.h"
#include "renderers/trace/packet_visibility.h"

namespace occlab {
namespace {

constexpr int tile_size = 4;
static_assert(tile_size * tile_size == lane_count);

/// The points of a tile, world space; inactive lanes hold harmless values.
struct Tile {
  LaneMask active;
  bool any = false;
  Lanes3 origin;  ///< lifted off the surface
  Lanes3 tangent, bitangent, normal;
  std::array<glm::vec3, lane_count> position{};
  std::array<glm::vec3, lane_count> albedo{};
};

/// A texel's radiance and the density with which the sampler draws it, one look-up for both.
struct ProbeTable {
  int width;
  int height;
  glm::mat3 probe_from_world;
  std::vector<glm::vec4> texels;  // rgb, pdf

  std::size_t index(float x, float y, float z) const {
    const float u = 0.5f + lane_atan2(z, x) * float(0.5 / 3.14159265358979);
    const float v = lane_acos(y) * float(1.0 / 3.14159265358979);
    const int column = std::clamp(int(u * float(width)), 0, width - 1);
    const int row = std::clamp(int(v * float(height)), 0, height - 1);
    return std::size_t(row) * std::size_t(width) + std::size_t(column);
  }
};

ProbeTable make_table(const Environment& environment, const EnvironmentSampler& sampler) {
  const Image& image = environment.texels;
  ProbeTable table{image.width(), image.height(), environment.probe_from_world, {}};
  const glm::mat3 world_from_probe = glm::transpose(environment.probe_from_world);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const glm::vec2 uv((float(x) + 0.5f) / float(image.width()),
                         (float(y) + 0.5f) / float(image.height()));
      table.texels.emplace_back(image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2),
                                sampler.pdf(world_from_probe * equirect_direction(uv)));
    }
  }
  return table;
}

/// Sums of a few hundred rays for the 16 pixels.
struct RaySums {
  Lanes3 light;      ///< of L v cos / pdf
  Lanes visibility;  ///< of v over cosine-distributed directions
};

/// Sums of one batch. Doubles: floats would drift by 3e-4 of the result at a million rays.
struct BatchSums {
  std::array<glm::dvec3, lane_count> light{};
  std::array<double, lane_count> visibility{};

  void add(const RaySums& rays) {
    for (int i = 0; i < lane_count; ++i) {
      const auto lane = std::size_t(i);
      light[lane] += glm::dvec3(rays.light.x[i], rays.light.y[i], rays.light.z[i]);
      visibility[lane] += double(rays.visibility[i]);
    }
  }
};
constexpr long rays_per_sum = 256;

std::uint32_t hash(std::uint32_t value) {
  // PCG output permutation [Jarzynski and Olano 2020, "Hash Functions for GPU Rendering"].
  const std::uint32_t state = value * 747796405u + 2891336453u;
  const std::uint32_t word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return (word >> 22u) ^ word;
}

/// The R2 sequence [Roberts 2018], shifted at random: stratified, and unbiased over the shifts.
class PointSequence {
 public:
  PointSequence(std::uint64_t seed, std::uint32_t tile, std::uint32_t batch,
                std::uint32_t purpose) {
    std::uint32_t state = hash(std::uint32_t(seed)) ^ std::uint32_t(seed >> 32);
    for (const std::uint32_t part : {tile, batch, purpose}) state = hash(state ^ hash(part));
    u_ = hash(state);
    v_ = hash(u_ + 0x9e3779b9u);
  }
  std::pair<float, float> next() {
    u_ += 3242174889u;  // 2^32 / plastic number
    v_ += 2447445414u;  // 2^32 / plastic number^2
    return {float(u_ >> 8) * 0x1p-24f, float(v_ >> 8) * 0x1p-24f};
  }

 private:
  std::uint32_t u_;
  std::uint32_t v_;
};

class TileTracer {
 public:
  TileTracer(const TracedScene& traced, const TraceSettings& settings, const ProbeTable& table,
             const EnvironmentSampler& sampler)
      : settings_(settings),
        table_(table),
        sampler_(sampler),
        visibility_(traced, {settings.weight, settings.d_max_world, settings.lambda_per_world,
                             settings.fade_start}) {}

  /// Directions p(w) = cos/pi about each pixel's normal.
  void add_cosine(const Tile& tile, float u, float v, float other_density_share, RaySums& sums) {
    const float radius = std::sqrt(u);
    const float x = radius * std::cos(2.0f * pi * v);
    const float y = radius * std::sin(2.0f * pi * v);
    const float cosine = std::sqrt(1.0f - u);
    Lanes3 direction;
    for (int i = 0; i < lane_count; ++i) {
      direction.x[i] = tile.tangent.x[i] * x + tile.bitangent.x[i] * y + tile.normal.x[i] * cosine;
      direction.y[i] = tile.tangent.y[i] * x + tile.bitangent.y[i] * y + tile.normal.y[i] * cosine;
      direction.z[i] = tile.tangent.z[i] * x + tile.bitangent.z[i] * y + tile.normal.z[i] * cosine;
    }
    const Lanes visible = visibility_(tile.origin, tile.active, direction, reach_);
    const auto& m = table_.probe_from_world;
    const float pdf = cosine / pi;
    for (int i = 0; i < lane_count; ++i) {
      const float px =
          m[0][0] * direction.x[i] + m[1][0] * direction.y[i] + m[2][0] * direction.z[i];
      const float py =
          m[0][1] * direction.x[i] + m[1][1] * direction.y[i] + m[2][1] * direction.z[i];
      const float pz =
          m[0][2] * direction.x[i] + m[1][2] * direction.y[i] + m[2][2] * direction.z[i];
      const glm::vec4& texel = table_.texels[table_.index(px, py, pz)];
      const float scale = visible[i] * cosine / (pdf + other_density_share * texel.w);
      sums.light.x[i] += texel.x * scale;
      sums.light.y[i] += texel.y * scale;
      sums.light.z[i] += texel.z * scale;
      sums.visibility[i] += visible[i];
    }
  }

  /// Directions in proportion to the probe's texels, one for the whole tile.
  void add_environment(const Tile& tile, float u, float v, float other_density_share,
                       RaySums& sums) {
    const EnvironmentSampler::Sample sample = sampler_.sample(u, v);
    const glm::vec3 d = sample.direction_world;
    Lanes3 direction;
    Lanes cosine;
    LaneMask active;
    int any = 0;
    for (int i = 0; i < lane_count; ++i) {
      direction.x[i] = d.x;
      direction.y[i] = d.y;
      direction.z[i] = d.z;
      cosine[i] = tile.normal.x[i] * d.x + tile.normal.y[i] * d.y + tile.normal.z[i] * d.z;
      active[i] = cosine[i] > 0.0f ? tile.active[i] : 0;
      any |= active[i];
    }
    if (!any) return;
    const Lanes visible = visibility_(tile.origin, active, direction, reach_);
    for (int i = 0; i < lane_count; ++i) {
      const float density = sample.pdf + other_density_share * cosine[i] / pi;
      const float scale = active[i] ? visible[i] * cosine[i] / density : 0.0f;
      sums.light.x[i] += sample.radiance.x * scale;
      sums.light.y[i] += sample.radiance.y * scale;
      sums.light.z[i] += sample.radiance.z * scale;
    }
  }

  /// Irradiance of a punctual light at each pixel, shadowed by one ray.
  void add_light(const Tile& tile, const Light& light, std::array<glm::vec3, lane_count>& sum) {
    Lanes3 direction;
    Lanes distance;
    LaneMask active;
    std::array<glm::vec3, lane_count> irradiance;
    for (int i = 0; i < lane_count; ++i) {
      const auto lane = std::size_t(i);
      const IncidentLight incident = incident_light(punctual_light(light), tile.position[lane]);
      const glm::vec3 n(tile.normal.x[i], tile.normal.y[i], tile.normal.z[i]);
      irradiance[lane] = incident.irradiance * std::max(dot(n, incident.direction), 0.0f);
      direction.x[i] = incident.direction.x;
      direction.y[i] = incident.direction.y;
      direction.z[i] = incident.direction.z;
      distance[i] = std::min(settings_.d_max_world, incident.distance);
      active[i] = irradiance[lane] == glm::vec3(0.0f) ? 0 : tile.active[i];
    }
    const Lanes visible = visibility_(tile.origin, active, direction, distance);
    for (int i = 0; i < lane_count; ++i) {
      if (active[i]) sum[std::size_t(i)] += visible[i] * irradiance[std::size_t(i)];
    }
  }

  void set_reach(float distance) { reach_.v.fill(distance); }

 private:
  const TraceSettings& settings_;
  const ProbeTable& table_;
  const EnvironmentSampler& sampler_;
  PacketVisibility visibility_;
  Lanes reach_;
};

glm::vec3 vec3_at(const Image& image, int x, int y) {
  return {image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
}

void set_lane(Lanes3& lanes, int lane, glm::vec3 value) {
  lanes.x[lane] = value.x;
  lanes.y[lane] = value.y;
  lanes.z[lane] = value.z;
}

Tile load_tile(const SurfacePoints& points, const View& view, int x0, int y0, float epsilon) {
  const glm::mat3 rotation = view.world_from_view_rotation();
  const glm::vec3 eye(view.camera.world_from_camera[3]);
  Tile tile;
  for (int i = 0; i < lane_count; ++i) {
    const int x = x0 + i % tile_size;
    const int y = y0 + i / tile_size;
    const bool inside = x < view.width && y < view.height && points.mask.at(x, y) > 0.5f;
    if (!inside) {
      set_lane(tile.normal, i, {0, 1, 0});
      set_lane(tile.tangent, i, {1, 0, 0});
      set_lane(tile.bitangent, i, {0, 0, 1});
      continue;
    }
    tile.active[i] = -1;
    tile.any = true;
    const glm::vec3 position = eye + rotation * vec3_at(points.position_view, x, y);
    // The frame is built in view space and then turned, as the passes do.
    const glm::mat3 frame = rotation * tangent_frame(vec3_at(points.normal_view, x, y));
    set_lane(tile.tangent, i, frame[0]);
    set_lane(tile.bitangent, i, frame[1]);
    set_lane(tile.normal, i, frame[2]);
    set_lane(tile.origin, i,
             position + epsilon * (rotation * vec3_at(points.geometric_normal_view, x, y)));
    tile.position[std::size_t(i)] = position;
    tile.albedo[std::size_t(i)] = vec3_at(points.albedo, x, y);
  }
  return tile;
}

/// Running mean and sum of squared deviations of the batches [Welford 1962], one RGB a lane.
struct BatchStatistics {
  std::array<glm::dvec3, lane_count> mean{};
  std::array<glm::dvec3, lane_count> squares{};
  std::array<double, lane_count> visibility{};

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
  const ProbeTable table = make_table(environment, sampler);
  const bool use_cosine = settings.estimator != Estimator::environment;
  // A black probe has no texel to draw.
  const bool use_environment = settings.estimator != Estimator::cosine && !sampler.black();
  const long strategies = long(use_cosine) + long(use_environment);
  const long per_round = reference_batches * std::max(1L, strategies);
  const long per_batch = std::max(1L, (settings.rays_per_pixel + per_round - 1) / per_round);
  // Balance heuristic with as many samples of either strategy: the densities add [Veach 1997].
  const float other_share = strategies == 2 ? 1.0f : 0.0f;

  Reference result;
  result.radiance = Image(view.width, view.height, 3);
  result.radiance_variance = Image(view.width, view.height, 3);
  if (use_cosine) result.ambient_occlusion = Image(view.width, view.height, 1);
  result.rays_per_pixel = per_batch * strategies * reference_batches;

  const int tiles_x = (view.width + tile_size - 1) / tile_size;
  const int tiles_y = (view.height + tile_size - 1) / tile_size;
  const float epsilon = 1e-4f * traced.bounding_radius();
  std::atomic<std::uint64_t> pixels_traced{0};

  parallel_for(std::size_t(tiles_y), [&](std::size_t tile_row) {
    throw_if_interrupted();
    TileTracer tracer(traced, settings, table, sampler);
    tracer.set_reach(settings.d_max_world);
    for (int tile_column = 0; tile_column < tiles_x; ++tile_column) {
      const int x0 = tile_column * tile_size;
      const int y0 = int(tile_row) * tile_size;
      const Tile tile = load_tile(points, view, x0, y0, epsilon);
      if (!tile.any) continue;
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
              tracer.add_cosine(tile, u, v, other_share, rays);
            }
            if (use_environment) {
              const auto [u, v] = environment_points.next();
              tracer.add_environment(tile, u, v, other_share, rays);
            }
          }
          sums.add(rays);
        }
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
          statistics.add(lane, batch + 1, sums.light[lane] / double(per_batch));
          statistics.visibility[lane] += sums.visibility[lane] / double(per_batch);
        }
      }

      std::array<glm::vec3, lane_count> from_lights{};
      for (const Light& light : lights) tracer.add_light(tile, light, from_lights);

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
        }
        if (use_cosine) {
          result.ambient_occlusion.at(x, y) =
              float(statistics.visibility[lane] / double(reference_batches));
        }
        ++pixels_traced;
      }
    }
  });
  result.rays = pixels_traced * std::uint64_t(result.rays_per_pixel + long(lights.size()));
  return result;
}

}  // namespace occlab
