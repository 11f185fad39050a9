#pragma once

#include <array>
#include <vector>

#include "renderers/trace/packet.h"
#include "renderers/trace/traced_scene.h"

namespace occlab {

/// What rays meet, as surfaces that send light: the nearest hits of 16 rays at once.
class SurfaceRays {
 public:
  /// Both outlive this.
  SurfaceRays(const TracedScene& traced, const Scene& scene);

  /// World space. Normals are unit and, surfaces being two-sided, on the ray's side of the
  /// triangle.
  struct Hit {
    bool found = false;
    float distance = 0.0f;
    glm::vec3 position{0.0f};
    glm::vec3 normal{0.0f};  ///< shading
    glm::vec3 geometric_normal{0.0f};
    glm::vec3 albedo{0.0f};
  };
  using Hits = std::array<Hit, lane_count>;

  /// Of each active lane within `distance`. Directions have length 1.
  Hits nearest(const Lanes3& origin, const LaneMask& active, const Lanes3& direction,
               const Lanes& distance) const;

 private:
  Hit hit_at(const SurfaceHit& where, glm::vec3 origin, glm::vec3 direction, float distance) const;

  RTCScene handle_;
  const Scene& scene_;
  std::vector<glm::mat3> normal_from_object_;  ///< of each instance
};

}  // namespace occlab
