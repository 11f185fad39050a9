#pragma once

#include <embree3/rtcore.h>

#include <memory>

#include "renderers/scene/scene.h"
#include "renderers/scene/surface_texture.h"
#include "renderers/trace/alpha_mask.h"
#include "renderers/trace/triangle_tree.h"

namespace occlab {

/// A scene's triangles in Embree, world space. A mesh that is used once is stored with its
/// transform applied; a mesh that is used more often is stored once and instanced. Triangles are
/// two-sided; rays pass where their material's alpha mask has holes.
class TracedScene {
 public:
  explicit TracedScene(const Scene& scene);

  RTCScene handle() const { return scene_.get(); }
  const TriangleTree& tree() const { return tree_; }

  /// Where a ray met a surface, in the terms of the Scene: from the instID[0], geomID, primID, u
  /// and v of Embree's hit. Geometries are attached in the order of the instances.
  static SurfaceHit surface_hit(unsigned instance, unsigned geometry, unsigned triangle, float u,
                                float v) {
    const unsigned index = instance == RTC_INVALID_GEOMETRY_ID ? geometry : instance;
    return {int(index), triangle, {u, v}};
  }
  /// Of the box around everything; ray epsilons are relative to it.
  float bounding_radius() const { return bounding_radius_; }
  /// How far above a surface, along its geometric normal, rays start. Ten times as high, ambient
  /// occlusion of curved surfaces is up to 4e-3 too bright, as Cycles shows; ten times as low, flat
  /// surfaces begin to occlude themselves.
  float ray_lift_world() const { return 1e-5f * bounding_radius_; }

 private:
  struct Release {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };
  std::vector<std::unique_ptr<const AlphaMask>> masks_;  // Embree's geometries ask them
  std::unique_ptr<RTCDeviceTy, Release> device_;
  std::unique_ptr<RTCSceneTy, Release> scene_;
  float bounding_radius_ = 0.0f;
  TriangleTree tree_;
};

}  // namespace occlab
