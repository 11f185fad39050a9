#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "renderers/scene/scene.h"

namespace occlab {

/// A scene's triangles, world space, under a binary tree of boxes, for what Embree does not answer:
/// which triangles can the rays of a tile meet at all (tile_candidates.h)?
class TriangleTree {
 public:
  struct Triangle {
    glm::vec3 corner;
    glm::vec3 edge1;  ///< from `corner` to the second corner
    glm::vec3 edge2;  ///< from `corner` to the third
    glm::vec3 normal() const { return cross(edge1, edge2); }  ///< not of length 1
  };
  /// Nodes are stored depth first: the left child of an inner node follows it.
  struct Node {
    glm::vec3 lower;
    std::uint32_t link;  ///< inner: index of the right child; leaf: of the first triangle
    glm::vec3 upper;
    std::uint32_t count : 30;  ///< triangles below
    std::uint32_t leaf : 1;
    std::uint32_t masked : 1;  ///< some of them may have holes, which only Embree is told of
  };

  /// Instances are written out, so the tree takes about 80 bytes a triangle. Throws DeviceError.
  TriangleTree(RTCDevice device, const Scene& scene);

  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }

 private:
  std::vector<Node> nodes_;
  std::vector<Triangle> triangles_;
};

}  // namespace occlab
