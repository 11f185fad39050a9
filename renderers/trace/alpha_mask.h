#pragma once

#include <embree3/rtcore.h>

#include <array>
#include <memory>
#include <vector>

#include "renderers/scene/scene.h"

namespace occlab {

/// The holes of a mesh: what Embree asks wherever a ray meets one of its triangles. Holds copies of
/// all it needs.
class AlphaMask {
 public:
  /// `alpha`: the alpha channel of the material's texture; null if it has none. The material has a
  /// cutoff.
  AlphaMask(const Mesh& mesh, const Material& material, std::shared_ptr<const Image> alpha);

  /// Has `geometry`, the mesh's, ask this mask, which must outlive it.
  void attach_to(RTCGeometry geometry) const;

  /// Whether there is a surface at a point of a triangle, by the weights of its second and third
  /// corner.
  bool surface_at(std::size_t triangle, float second, float third) const;

 private:
  std::vector<std::array<glm::vec2, 3>> corner_uvs_;  ///< a triangle; none without texture
  std::shared_ptr<const Image> alpha_;
  TextureSampling sampling_;
  float factor_;
  float cutoff_;
};

/// The masks of a scene's meshes: null where the material has none. Textures are shared.
std::vector<std::unique_ptr<const AlphaMask>> alpha_masks(const Scene& scene);

}  // namespace occlab
