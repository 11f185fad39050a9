#include "renderers/trace/triangle_tree.h"

#include <algorithm>
#include <memory>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

using Triangle = TriangleTree::Triangle;
using Node = TriangleTree::Node;

constexpr unsigned leaf_size = 4;

/// As Embree's builder makes it.
struct BuildNode {
  BuildNode* children[2] = {};  ///< both or none
  const RTCBuildPrimitive* primitives = nullptr;
  std::size_t count = 0;
};

void* create_node(RTCThreadLocalAllocator allocator, unsigned, void*) {
  return new (rtcThreadLocalAlloc(allocator, sizeof(BuildNode), alignof(BuildNode))) BuildNode;
}

void set_children(void* node, void** children, unsigned, void*) {
  for (int i = 0; i < 2; ++i) {
    static_cast<BuildNode*>(node)->children[i] = static_cast<BuildNode*>(children[i]);
  }
}

/// Boxes are computed from the triangles when the tree is written out.
void ignore_bounds(void*, const RTCBounds**, unsigned, void*) {}

void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives,
                  std::size_t count, void*) {
  void* memory = rtcThreadLocalAlloc(allocator, sizeof(BuildNode), alignof(BuildNode));
  return new (memory) BuildNode{{}, primitives, count};
}

/// The scene's triangles, world space, and which of them have an alpha mask.
struct SourceTriangles {
  std::vector<Triangle> triangles;
  std::vector<bool> masked;
};

SourceTriangles world_triangles(const Scene& scene) {
  SourceTriangles source;
  source.triangles.reserve(scene.triangle_count());
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[std::size_t(instance.mesh)];
    const auto corner = [&](std::size_t index) {
      const glm::vec3& position = mesh.positions[mesh.indices[index]];
      return glm::vec3(instance.world_from_object * glm::vec4(position, 1.0f));
    };
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      const glm::vec3 first = corner(i);
      source.triangles.push_back({first, corner(i + 1) - first, corner(i + 2) - first});
    }
    const bool masked = scene.materials[std::size_t(mesh.material)].alpha_cutoff.has_value();
    source.masked.resize(source.triangles.size(), masked);
  }
  return source;
}

std::vector<RTCBuildPrimitive> boxes(const std::vector<Triangle>& triangles) {
  std::vector<RTCBuildPrimitive> primitives(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Triangle& t = triangles[i];
    const glm::vec3 lower = t.corner + min(min(t.edge1, t.edge2), glm::vec3(0.0f));
    const glm::vec3 upper = t.corner + max(max(t.edge1, t.edge2), glm::vec3(0.0f));
    primitives[i] = {lower.x, lower.y, lower.z, 0, upper.x, upper.y, upper.z, unsigned(i)};
  }
  return primitives;
}

/// Writes a subtree out depth first.
class Flattener {
 public:
  Flattener(const SourceTriangles& source, std::vector<Node>& nodes,
            std::vector<Triangle>& triangles)
      : source_(source), nodes_(nodes), triangles_(triangles) {}

  std::uint32_t write(const BuildNode& from) {
    const auto index = std::uint32_t(nodes_.size());
    nodes_.emplace_back();
    if (!from.children[0]) {
      write_leaf(from, nodes_[index]);
      return index;
    }
    write(*from.children[0]);
    const std::uint32_t right = write(*from.children[1]);
    const Node& a = nodes_[index + 1];
    const Node& b = nodes_[right];
    nodes_[index] = {.lower = min(a.lower, b.lower),
                     .link = right,
                     .upper = max(a.upper, b.upper),
                     .count = (a.count + b.count) & 0x3fffffffu,
                     .leaf = 0,
                     .masked = (a.masked != 0 || b.masked != 0) ? 1u : 0u};
    return index;
  }

 private:
  void write_leaf(const BuildNode& from, Node& node) {
    node.link = std::uint32_t(triangles_.size());
    node.count = std::uint32_t(from.count) & 0x3fffffffu;
    node.leaf = 1;
    node.masked = 0;
    node.lower = glm::vec3(std::numeric_limits<float>::infinity());
    node.upper = -node.lower;
    for (std::size_t i = 0; i < from.count; ++i) {
      const RTCBuildPrimitive& box = from.primitives[i];
      node.lower = min(node.lower, glm::vec3(box.lower_x, box.lower_y, box.lower_z));
      node.upper = max(node.upper, glm::vec3(box.upper_x, box.upper_y, box.upper_z));
      triangles_.push_back(source_.triangles[box.primID]);
      if (source_.masked[box.primID]) node.masked = 1;
    }
  }

  const SourceTriangles& source_;
  std::vector<Node>& nodes_;
  std::vector<Triangle>& triangles_;
};

struct ReleaseBVH {
  void operator()(RTCBVH bvh) const { rtcReleaseBVH(bvh); }
};

}  // namespace

TriangleTree::TriangleTree(RTCDevice device, const Scene& scene) {
  const SourceTriangles source = world_triangles(scene);
  std::vector<RTCBuildPrimitive> primitives = boxes(source.triangles);
  const std::unique_ptr<RTCBVHTy, ReleaseBVH> bvh(rtcNewBVH(device));
  RTCBuildArguments arguments = rtcDefaultBuildArguments();
  arguments.maxLeafSize = leaf_size;
  arguments.bvh = bvh.get();
  arguments.primitives = primitives.data();
  arguments.primitiveCount = primitives.size();
  arguments.primitiveArrayCapacity = primitives.size();
  arguments.createNode = create_node;
  arguments.setNodeChildren = set_children;
  arguments.setNodeBounds = ignore_bounds;
  arguments.createLeaf = create_leaf;
  const auto* root = static_cast<const BuildNode*>(rtcBuildBVH(&arguments));
  if (!root) throw DeviceError("Embree failed in building the tree of triangles");
  nodes_.reserve(source.triangles.size());
  triangles_.reserve(source.triangles.size());
  Flattener(source, nodes_, triangles_).write(*root);
}

}  // namespace occlab
