#include "harness/split_triangles.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

struct Corner {
  glm::vec3 position;
  glm::vec3 normal;
  glm::vec2 uv;
};

Corner corner_of(const Mesh& mesh, std::uint32_t index) {
  return {mesh.positions[index], mesh.normals[index],
          mesh.uvs.empty() ? glm::vec2(0.0f) : mesh.uvs[index]};
}

/// In an order that does not depend on which triangle an edge belongs to.
bool before(const glm::vec3& a, const glm::vec3& b) {
  for (int i = 0; i < 3; ++i) {
    if (a[i] != b[i]) return a[i] < b[i];
  }
  return false;
}

template <typename Vector>
Vector weighted(const Vector& a, const Vector& b, const Vector& c, const glm::dvec3& weights) {
  using Precise = glm::vec<Vector::length(), double>;
  return Vector(Precise(a) * weights.x + Precise(b) * weights.y + Precise(c) * weights.z);
}

void add_vertex(Mesh& mesh, bool textured, const std::array<Corner, 3>& corners,
                std::array<int, 3> weights, int parts) {
  // Sorted, the sum over an edge's two ends (the third weight is 0) is the same from both sides.
  std::array<std::size_t, 3> order = {0, 1, 2};
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return before(corners[i].position, corners[j].position);
  });
  const Corner& a = corners[order[0]];
  const Corner& b = corners[order[1]];
  const Corner& c = corners[order[2]];
  const glm::dvec3 w =
      glm::dvec3(weights[order[0]], weights[order[1]], weights[order[2]]) / double(parts);
  mesh.positions.push_back(weighted(a.position, b.position, c.position, w));
  mesh.normals.push_back(glm::normalize(weighted(a.normal, b.normal, c.normal, w)));
  if (textured) mesh.uvs.push_back(weighted(a.uv, b.uv, c.uv, w));
}

/// Rows of points parallel to the edge from the second corner to the third.
void split_triangle(Mesh& mesh, bool textured, const std::array<Corner, 3>& corners, int parts) {
  const auto first = std::uint32_t(mesh.positions.size());
  for (int row = 0; row <= parts; ++row) {
    for (int i = 0; i <= row; ++i) {
      add_vertex(mesh, textured, corners, {parts - row, row - i, i}, parts);
    }
  }
  const auto point = [&](int row, int i) { return first + std::uint32_t(row * (row + 1) / 2 + i); };
  for (int row = 0; row < parts; ++row) {
    for (int i = 0; i <= row; ++i) {
      for (const std::uint32_t index : {point(row, i), point(row + 1, i), point(row + 1, i + 1)}) {
        mesh.indices.push_back(index);
      }
      if (i == row) continue;
      for (const std::uint32_t index : {point(row, i), point(row + 1, i + 1), point(row, i + 1)}) {
        mesh.indices.push_back(index);
      }
    }
  }
}

}  // namespace

int split_factor(std::size_t triangles, std::size_t wanted) {
  if (wanted < triangles) {
    throw InputError(
        fmt::format("{} triangles were asked for and the scene has {}; triangles are only split",
                    wanted, triangles));
  }
  const double exact = std::sqrt(double(wanted) / double(triangles));
  const double below = std::floor(exact);
  return int(exact / below > (below + 1.0) / exact ? below + 1.0 : below);
}

Scene split_triangles(const Scene& scene, int parts) {
  Scene result = scene;
  for (Mesh& mesh : result.meshes) {
    const Mesh old = std::move(mesh);
    mesh = {old.name, {}, {}, {}, {}, old.material};
    for (std::size_t i = 0; i + 2 < old.indices.size(); i += 3) {
      split_triangle(mesh, !old.uvs.empty(),
                     {corner_of(old, old.indices[i]), corner_of(old, old.indices[i + 1]),
                      corner_of(old, old.indices[i + 2])},
                     parts);
    }
  }
  return result;
}

}  // namespace occlab
