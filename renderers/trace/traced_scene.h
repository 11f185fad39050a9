#pragma once

#include <embree3/rtcore.h>

#include <memory>

#include "renderers/scene/scene.h"
#include "renderers/trace/triangle_tree.h"

namespace occlab {

/// A scene's triangles in Embree, world space. A mesh that is used once is stored with its
/// transform applied; a mesh that is used more often is stored once and instanced.
class TracedScene {
 public:
  explicit TracedScene(const Scene& scene);

  RTCScene handle() const { return scene_.get(); }
  const TriangleTree& tree() const { return tree_; }
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
  std::unique_ptr<RTCDeviceTy, Release> device_;
  std::unique_ptr<RTCSceneTy, Release> scene_;
  float bounding_radius_ = 0.0f;
  TriangleTree tree_;
};

}  // namespace occlab
