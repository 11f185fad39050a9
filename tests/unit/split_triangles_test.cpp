// A scene made of more triangles is the same scene.

#include "harness/split_triangles.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <tuple>

#include "renderers/scene/data_root.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

using Key = std::tuple<float, float, float>;
Key key(const glm::vec3& p) { return {p.x, p.y, p.z}; }

double area(const Mesh& mesh) {
  double sum = 0.0;
  for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const glm::dvec3 a = mesh.positions[mesh.indices[i]];
    const glm::dvec3 b = mesh.positions[mesh.indices[i + 1]];
    const glm::dvec3 c = mesh.positions[mesh.indices[i + 2]];
    sum += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  return sum;
}

glm::dvec3 normal_of(const Mesh& mesh, std::size_t triangle) {
  const glm::dvec3 a = mesh.positions[mesh.indices[3 * triangle]];
  const glm::dvec3 b = mesh.positions[mesh.indices[3 * triangle + 1]];
  const glm::dvec3 c = mesh.positions[mesh.indices[3 * triangle + 2]];
  return glm::normalize(glm::cross(b - a, c - a));
}

TEST(SplitTriangles, FactorThatComesClosest) {
  EXPECT_EQ(split_factor(38, 38), 1);
  EXPECT_EQ(split_factor(38, 950), 5);
  EXPECT_EQ(split_factor(38, 1000), 5);
  EXPECT_EQ(split_factor(38, 2000000), 229);
  EXPECT_EQ(split_factor(100, 199), 1) << "in ratio: sqrt(2) is between";
  EXPECT_EQ(split_factor(100, 201), 2);
  EXPECT_THROW(split_factor(38, 37), InputError);
}

TEST(SplitTriangles, SameSurfacesMoreTriangles) {
  const Scene scene = load_scene(scene_path("three_boxes"));
  for (const int parts : {1, 2, 7}) {
    const Scene split = split_triangles(scene, parts);
    EXPECT_EQ(split.triangle_count(), scene.triangle_count() * std::size_t(parts * parts));
    ASSERT_EQ(split.meshes.size(), scene.meshes.size());
    EXPECT_EQ(split.instances.size(), scene.instances.size());
    EXPECT_EQ(split.bounds_max, scene.bounds_max);
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
      const Mesh& before = scene.meshes[m];
      const Mesh& after = split.meshes[m];
      EXPECT_NEAR(area(after), area(before), 1e-5 * area(before));
      EXPECT_EQ(after.normals.size(), after.positions.size());
      EXPECT_EQ(after.uvs.size(), before.uvs.empty() ? 0 : after.positions.size());
      EXPECT_EQ(after.material, before.material);
      const auto each = std::size_t(parts) * std::size_t(parts);
      for (std::size_t t = 0; t < after.indices.size() / 3; ++t) {
        EXPECT_GT(glm::dot(normal_of(after, t), normal_of(before, t / each)), 0.9999)
            << "the same side is outside";
      }
    }
  }
}

/// Every edge inside of a closed surface is met by two triangles, in opposite directions and with
/// the same ends to the last bit.
TEST(SplitTriangles, EdgesStayClosed) {
  Scene scene;
  Mesh mesh;
  // A tetrahedron with awkward coordinates, its corners not shared between its faces.
  const glm::vec3 p[4] = {
      {0.1f, 0.2f, 0.3f}, {1.7f, 0.13f, 0.31f}, {0.3f, 1.9f, 0.7f}, {0.57f, 0.61f, 2.3f}};
  for (const auto& face :
       {glm::ivec3(0, 2, 1), glm::ivec3(0, 1, 3), glm::ivec3(1, 2, 3), glm::ivec3(2, 0, 3)}) {
    for (int c = 0; c < 3; ++c) {
      mesh.indices.push_back(std::uint32_t(mesh.positions.size()));
      mesh.positions.push_back(p[face[c]]);
      mesh.normals.emplace_back(0.0f, 0.0f, 1.0f);
    }
  }
  scene.meshes = {mesh};
  scene.instances = {{0}};
  const Scene split = split_triangles(scene, 13);
  const Mesh& after = split.meshes.front();
  std::map<std::pair<Key, Key>, int> edges;
  for (std::size_t i = 0; i < after.indices.size(); i += 3) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Key a = key(after.positions[after.indices[i + c]]);
      const Key b = key(after.positions[after.indices[i + (c + 1) % 3]]);
      ++edges[{a, b}];
    }
  }
  EXPECT_EQ(edges.size(), 3u * 4 * 13 * 13);
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_TRUE(edges.contains({edge.second, edge.first}));
  }
}

}  // namespace
}  // namespace occlab
