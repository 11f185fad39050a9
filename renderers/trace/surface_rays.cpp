#include "renderers/trace/surface_rays.h"

namespace occlab {

SurfaceRays::SurfaceRays(const TracedScene& traced, const Scene& scene)
    : handle_(traced.handle()), scene_(scene) {
  for (const Instance& instance : scene.instances) {
    normal_from_object_.push_back(
        glm::transpose(glm::inverse(glm::mat3(instance.world_from_object))));
  }
}

SurfaceRays::Hits SurfaceRays::nearest(const Lanes3& origin, const LaneMask& active,
                                       const Lanes3& direction, const Lanes& distance) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit16 packet;
  fill_rays(packet.ray, origin, direction, distance);
  for (int i = 0; i < lane_count; ++i) {
    packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  rtcIntersect16(active.v.data(), handle_, &context, &packet);
  Hits hits;
  for (int i = 0; i < lane_count; ++i) {
    if (!active[i] || packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    const SurfaceHit where =
        TracedScene::surface_hit(packet.hit.instID[0][i], packet.hit.geomID[i],
                                 packet.hit.primID[i], packet.hit.u[i], packet.hit.v[i]);
    hits[std::size_t(i)] = hit_at(where, at(origin, i), at(direction, i), packet.ray.tfar[i]);
  }
  return hits;
}

SurfaceRays::Hit SurfaceRays::hit_at(const SurfaceHit& where, glm::vec3 origin, glm::vec3 direction,
                                     float distance) const {
  const Instance& instance = scene_.instances[std::size_t(where.instance)];
  const Mesh& mesh = scene_.meshes[std::size_t(instance.mesh)];
  const std::uint32_t* corners = &mesh.indices[std::size_t(3) * where.triangle];
  const glm::vec3 weights(1.0f - where.barycentric.x - where.barycentric.y, where.barycentric.x,
                          where.barycentric.y);
  const auto mixed = [&](const std::vector<glm::vec3>& of) {
    return weights.x * of[corners[0]] + weights.y * of[corners[1]] + weights.z * of[corners[2]];
  };
  const auto edge = [&](int corner) {
    return mesh.positions[corners[corner]] - mesh.positions[corners[0]];
  };
  const glm::mat3& normals = normal_from_object_[std::size_t(where.instance)];
  glm::vec3 geometric = normalize(normals * cross(edge(1), edge(2)));
  if (dot(geometric, direction) > 0.0f) geometric = -geometric;
  // As in the G-buffer: on the geometric normal's side. Opposite normals of corners leave none.
  glm::vec3 shading = normals * mixed(mesh.normals);
  const float length = glm::length(shading);
  shading = length > 0.0f ? shading / length : geometric;
  if (dot(shading, geometric) < 0.0f) shading = -shading;
  return {.found = true,
          .distance = distance,
          .position = origin + distance * direction,
          .normal = shading,
          .geometric_normal = geometric,
          .albedo = albedo_at(scene_, where)};
}

}  // namespace occlab
