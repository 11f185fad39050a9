#include "renderers/trace/bounce_tracer.h"

#include <algorithm>
#include <cmath>

#include "renderers/shared/frame.h"
#include "renderers/shared/lights.h"

namespace occlab {
namespace {

glm::vec3 rgb(const ProbeTable::Texel& texel) { return {texel.r, texel.g, texel.b}; }

int count(const LaneMask& mask) {
  return int(std::ranges::count_if(mask.v, [](int active) { return active != 0; }));
}

}  // namespace

BounceTracer::BounceTracer(const TracedScene& traced, const TraceSettings& settings,
                           const ProbeTable& table, const EnvironmentSampler& sampler,
                           std::span<const Light> lights)
    : visibility_(traced, {settings.weight, settings.d_max_world, settings.lambda_per_world,
                           settings.fade_start}),
      surfaces_(traced, *settings.bounce->scene),
      settings_(settings),
      table_(table),
      sampler_(sampler),
      lift_world_(traced.ray_lift_world()) {
  for (const Light& light : lights) lights_.push_back(punctual_light(light));
  reach_.v.fill(settings.d_max_world);
}

void BounceTracer::set_tile(const Tile& tile, long rays) {
  tile_ = &tile;
  visibility_.set_tile(tile, CellKinds::tangent, rays);
}

void BounceTracer::add(float u, float v, RandomPoints& points, RaySums& sums) {
  const float radius = std::sqrt(u);
  const glm::vec3 d(radius * std::cos(2.0f * pi * v), radius * std::sin(2.0f * pi * v),
                    std::sqrt(1.0f - u));
  const Lanes3 direction = out_of(*tile_, d);
  // Near a flat wall most rays are known to meet nothing without being traced.
  const Lanes open = visibility_(tile_->active, direction, tangent_cell(u, v));
  LaneMask blocked;
  for (int i = 0; i < lane_count; ++i) blocked[i] = open[i] < 1.0f ? tile_->active[i] : 0;
  rays_ += std::uint64_t(count(tile_->active));
  const auto [cosine_u, cosine_v] = points.next();
  const auto [probe_u, probe_v] = points.next();
  if (count(blocked) == 0) return;
  SenderTile tile = senders(surfaces_.nearest(tile_->origin, blocked, direction, reach_));
  add_cosine_sample(cosine_u, cosine_v, tile);
  if (!sampler_.black()) add_environment_sample(probe_u, probe_v, tile);
  add_lights(tile);
  for (int i = 0; i < lane_count; ++i) {
    const auto lane = std::size_t(i);
    if (!tile.active[i]) continue;
    const glm::vec3 L = tile.albedo[lane] * tile.irradiance[lane] * (1.0f - open[i]);
    sums.light[lane] += _mm_set_ps(0.0f, L.z, L.y, L.x);  // pi L_o = rho E
  }
}

BounceTracer::SenderTile BounceTracer::senders(const SurfaceRays::Hits& hits) const {
  SenderTile tile;
  for (int i = 0; i < lane_count; ++i) {
    const SurfaceRays::Hit& hit = hits[std::size_t(i)];
    const glm::mat3 frame = tangent_frame(hit.found ? hit.normal : glm::vec3(0, 0, 1));
    set_lane(tile.tangent, i, frame[0]);
    set_lane(tile.bitangent, i, frame[1]);
    set_lane(tile.normal, i, frame[2]);
    if (!hit.found) continue;
    tile.active[i] = -1;
    tile.position[std::size_t(i)] = hit.position;
    tile.albedo[std::size_t(i)] = hit.albedo;
    set_lane(tile.origin, i, hit.position + lift_world_ * hit.geometric_normal);
  }
  return tile;
}

Lanes BounceTracer::visible(const SenderTile& tile, const LaneMask& active, const Lanes3& direction,
                            const Lanes& distance) {
  if (settings_.bounce->sent == SentLight::shaded) {
    rays_ += std::uint64_t(count(active));
    return visibility_.packets()(tile.origin, active, direction, distance);
  }
  Lanes all;
  all.v.fill(1.0f);
  return all;
}

/// By the balance heuristic with the probe's sample [Veach 1997].
void BounceTracer::add_cosine_sample(float u, float v, SenderTile& tile) {
  const float radius = std::sqrt(u);
  const float cosine = std::sqrt(1.0f - u);
  const Lanes3 direction =
      out_of(tile, {radius * std::cos(2.0f * pi * v), radius * std::sin(2.0f * pi * v), cosine});
  const Lanes open = visible(tile, tile.active, direction, reach_);
  for (const int half : half_lanes) {
    const Int8 index = table_.index(direction, half);
    for (int k = 0; k < 8; ++k) {
      const int i = half + k;
      if (!tile.active[i]) continue;
      const ProbeTable::Texel& texel = table_.texels[std::size_t(index[k])];
      const float density = cosine / pi + texel.pdf;
      if (density > 0.0f) {
        tile.irradiance[std::size_t(i)] += rgb(texel) * (open[i] * cosine / density);
      }
    }
  }
}

void BounceTracer::add_environment_sample(float u, float v, SenderTile& tile) {
  const EnvironmentSampler::Sample sample = sampler_.sample(u, v);
  Lanes3 direction;
  Lanes cosine;
  LaneMask active;
  for (int i = 0; i < lane_count; ++i) {
    set_lane(direction, i, sample.direction_world);
    cosine[i] = dot(at(tile.normal, i), sample.direction_world);
    active[i] = cosine[i] > 0.0f ? tile.active[i] : 0;
  }
  if (count(active) == 0) return;
  const Lanes open = visible(tile, active, direction, reach_);
  for (int i = 0; i < lane_count; ++i) {
    if (!active[i]) continue;
    tile.irradiance[std::size_t(i)] +=
        sample.radiance * (open[i] * cosine[i] / (sample.pdf + cosine[i] / pi));
  }
}

void BounceTracer::add_lights(SenderTile& tile) {
  for (const PunctualLight& light : lights_) {
    std::array<glm::vec3, lane_count> irradiance{};
    Lanes3 direction;
    Lanes distance;
    LaneMask active;
    for (int i = 0; i < lane_count; ++i) {
      const auto lane = std::size_t(i);
      if (!tile.active[i]) continue;
      const IncidentLight incident = incident_light(light, tile.position[lane]);
      irradiance[lane] =
          incident.irradiance * std::max(dot(at(tile.normal, i), incident.direction), 0.0f);
      set_lane(direction, i, incident.direction);
      distance[i] = std::min(settings_.d_max_world, incident.distance);
      active[i] = irradiance[lane] == glm::vec3(0.0f) ? 0 : -1;
    }
    if (count(active) == 0) continue;
    const Lanes open = visible(tile, active, direction, distance);
    for (int i = 0; i < lane_count; ++i) {
      if (active[i]) tile.irradiance[std::size_t(i)] += open[i] * irradiance[std::size_t(i)];
    }
  }
}

}  // namespace occlab
