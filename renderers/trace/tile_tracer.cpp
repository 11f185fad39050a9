#include "renderers/trace/tile_tracer.h"

#include <algorithm>
#include <cmath>

#include "renderers/scene/punctual.h"
#include "renderers/shared/frame.h"
#include "renderers/shared/lights.h"

namespace occlab {
namespace {

glm::vec3 vec3_at(const Image& image, int x, int y) {
  return {image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
}

}  // namespace

Tile load_tile(const SurfacePoints& points, const View& view, int x0, int y0, float lift_world) {
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
             position + lift_world * (rotation * vec3_at(points.geometric_normal_view, x, y)));
    tile.position[std::size_t(i)] = position;
    tile.albedo[std::size_t(i)] = vec3_at(points.albedo, x, y);
  }
  return tile;
}

void TileTracer::add_cosine(float u, float v, RaySums& sums) {
  const float radius = std::sqrt(u);
  const float x = radius * std::cos(2.0f * pi * v);
  const float y = radius * std::sin(2.0f * pi * v);
  const float cosine = std::sqrt(1.0f - u);
  const Lanes3 direction = out_of(*tile_, {x, y, cosine});
  // Texels are fetched while the rays are traced.
  alignas(32) std::array<const ProbeTable::Texel*, lane_count> texels;
  for (const int half : half_lanes) {
    const Int8 index = table_.index(direction, half);
    for (std::size_t i = 0; i < 8; ++i) {
      const ProbeTable::Texel* texel = &table_.texels[std::size_t(index[i])];
      _mm_prefetch(texel, _MM_HINT_T0);
      texels[std::size_t(half) + i] = texel;
    }
  }
  const Lanes visible = visibility_(tile_->active, direction, tangent_cell(u, v));
  const float pdf = cosine / pi;
  for (const int half : half_lanes) {
    const Float8 v8 = load8(visible, half);
    store8(sums.visibility, half, load8(sums.visibility, half) + v8);
    __m128 light[8];
    for (std::size_t i = 0; i < 8; ++i) {
      light[i] = _mm_load_ps(&texels[std::size_t(half) + i]->r);
    }
    Float8 density = all8(pdf);
    if (other_density_share_ != 0.0f) {
      const Float8 other = {light[0][3], light[1][3], light[2][3], light[3][3],
                            light[4][3], light[5][3], light[6][3], light[7][3]};
      density += other_density_share_ * other;
    }
    const Float8 scale = v8 * cosine / density;
    for (std::size_t i = 0; i < 8; ++i) {
      sums.light[std::size_t(half) + i] += light[i] * scale[i];
    }
  }
}

void TileTracer::add_environment(float u, float v, RaySums& sums) {
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
    cosine[i] = tile_->normal.x[i] * d.x + tile_->normal.y[i] * d.y + tile_->normal.z[i] * d.z;
    active[i] = cosine[i] > 0.0f ? tile_->active[i] : 0;
    any |= active[i];
  }
  if (!any) return;
  const Lanes visible = visibility_(active, direction, cube_cell(d));
  const __m128 light = {sample.radiance.x, sample.radiance.y, sample.radiance.z, 0.0f};
  for (const int half : half_lanes) {
    const Float8 above = load8(cosine, half) > 0.0f ? load8(cosine, half) : Float8{};
    const Float8 density = sample.pdf + other_density_share_ * above / pi;
    const Float8 scale = load8(visible, half) * above / density;
    for (std::size_t i = 0; i < 8; ++i) sums.light[std::size_t(half) + i] += light * scale[i];
  }
}

void TileTracer::add_light(const Light& light, std::array<glm::vec3, lane_count>& sum) {
  Lanes3 direction;
  Lanes distance;
  LaneMask active;
  std::array<glm::vec3, lane_count> irradiance;
  for (int i = 0; i < lane_count; ++i) {
    const auto lane = std::size_t(i);
    const IncidentLight incident = incident_light(punctual_light(light), tile_->position[lane]);
    const glm::vec3 n(tile_->normal.x[i], tile_->normal.y[i], tile_->normal.z[i]);
    irradiance[lane] = incident.irradiance * std::max(dot(n, incident.direction), 0.0f);
    direction.x[i] = incident.direction.x;
    direction.y[i] = incident.direction.y;
    direction.z[i] = incident.direction.z;
    distance[i] = std::min(settings_.d_max_world, incident.distance);
    active[i] = irradiance[lane] == glm::vec3(0.0f) ? 0 : tile_->active[i];
  }
  const Lanes visible = visibility_.packets()(tile_->origin, active, direction, distance);
  for (int i = 0; i < lane_count; ++i) {
    if (active[i]) sum[std::size_t(i)] += visible[i] * irradiance[std::size_t(i)];
  }
}

}  // namespace occlab
