#pragma once

#include "renderers/shared/visibility.h"
#include "renderers/trace/packet.h"
#include "renderers/trace/traced_scene.h"

namespace occlab {

/// What a blocker lets through (shared/visibility.h).
struct BlockerWeight {
  int weight = 0;            ///< weight_binary, ...
  float d_max_world = 0.0f;  ///< where the weights end; may be infinite
  float lambda_per_world = 1.0f;
  float fade_start = 0.75f;  ///< share of d_max
};

/// Visibility of 16 rays at once, those of pixels that are close together and look in directions
/// that are close together. One for each thread; the scene must outlive it.
class PacketVisibility {
 public:
  PacketVisibility(const TracedScene& traced, const BlockerWeight& weight)
      : scene_(traced.handle()), weight_(weight) {
    // Not RTC_INTERSECT_CONTEXT_FLAG_COHERENT: with it Embree 3.13.5's 16-wide traversal never
    // returned from some tiles of the gallery (640x360), and it was no faster elsewhere.
    rtcInitIntersectContext(&context_);
  }

  /// v in [0, 1] of each active lane, world space: 1 where nothing is hit nearer than `distance`,
  /// else the weight of the nearest hit's distance. Directions have length 1. What inactive lanes
  /// hold is without meaning.
  Lanes operator()(const Lanes3& origin, const LaneMask& active, const Lanes3& direction,
                   const Lanes& distance) {
    return weight_.weight == weight_binary ? binary(origin, active, direction, distance)
                                           : weighted(origin, active, direction, distance);
  }

  /// The distance of each active lane's nearest hit within `distance`; infinite where there is
  /// none.
  Lanes nearest(const Lanes3& origin, const LaneMask& active, const Lanes3& direction,
                const Lanes& distance) {
    RTCRayHit16 hit;
    fill_rays(hit.ray, origin, direction, distance);
    for (int i = 0; i < lane_count; ++i) hit.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect16(active.v.data(), scene_, &context_, &hit);
    Lanes result;
    for (int i = 0; i < lane_count; ++i) {
      result[i] = hit.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID
                      ? std::numeric_limits<float>::infinity()
                      : hit.ray.tfar[i];
    }
    return result;
  }

 private:
  Lanes binary(const Lanes3& origin, const LaneMask& active, const Lanes3& direction,
               const Lanes& distance) {
    RTCRay16 ray;
    fill_rays(ray, origin, direction, distance);
    rtcOccluded16(active.v.data(), scene_, &context_, &ray);
    Lanes visible;
    for (int i = 0; i < lane_count; ++i) visible[i] = ray.tfar[i] < 0.0f ? 0.0f : 1.0f;
    return visible;
  }

  Lanes weighted(const Lanes3& origin, const LaneMask& active, const Lanes3& direction,
                 const Lanes& distance) {
    const Lanes hit = nearest(origin, active, direction, distance);
    Lanes visible;
    for (int i = 0; i < lane_count; ++i) {
      visible[i] = std::isfinite(hit[i])
                       ? blocked_visibility(weight_.weight, hit[i], weight_.d_max_world,
                                            weight_.lambda_per_world, weight_.fade_start)
                       : 1.0f;
    }
    return visible;
  }

  RTCScene scene_;
  BlockerWeight weight_;
  RTCIntersectContext context_;
};

}  // namespace occlab
