// What a tile's lists of candidates answer is what Embree answers, for every cell, weight and
// reach.
#include "renderers/trace/tile_visibility.h"

#include <gtest/gtest.h>

#include <random>

#include "renderers/shared/frame.h"
#include "tests/analytic/built_scenes.h"

namespace occlab::test {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

class Random {
 public:
  float operator()(float low = 0.0f, float high = 1.0f) {
    return low + (high - low) * float(generator_() >> 8) * 0x1p-24f;
  }
  glm::vec3 direction() {
    const float z = (*this)(-1, 1);
    const float phi = (*this)(0, 2 * pi);
    const float r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
  }

 private:
  std::mt19937 generator_{7};
};

/// A floor, a wall and `count` triangles strewn over them, some of them instances of one mesh.
Scene strewn_scene(int count, float size) {
  Random random;
  SceneBuilder builder;
  builder.add(quad({-4, -4, 0}, {8, 0, 0}, {0, 8, 0})).add(quad({-4, 2, 0}, {8, 0, 0}, {0, 0, 4}));
  Mesh mesh;
  for (int i = 0; i < count; ++i) {
    const glm::vec3 corner(random(-2, 2), random(-2, 2), random(0, 2));
    // Every other one lies flat, in a box without thickness.
    const glm::vec3 a = i % 2 ? glm::vec3(1, 0, 0) : random.direction();
    const glm::vec3 b = i % 2 ? glm::vec3(0, 1, 0) : random.direction();
    for (const glm::vec3& p : {corner, corner + size * a, corner + size * b}) {
      mesh.indices.push_back(std::uint32_t(mesh.positions.size()));
      mesh.positions.push_back(p);
      mesh.normals.emplace_back(0, 0, 1);
    }
  }
  if (count > 0) builder.add(mesh);
  const Mesh twice = quad({0, 0, 0.2f}, {0.3f, 0, 0.1f}, {0, 0.3f, 0});
  builder.add(twice, glm::mat4(1.0f));
  glm::mat4 moved(1.0f);
  moved[0][0] = 2.0f;
  moved[3] = glm::vec4(-1, 0.5f, 0.1f, 1);
  return builder.instance(count > 0 ? 3 : 2, moved).build();
}

/// The same with a quarter of every strewn triangle and of every instance cut out.
Scene masked_scene(int count, float size) {
  Scene scene = strewn_scene(count, size);
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].albedo_texture = 0;
  scene.materials[1].alpha_cutoff = 0.5f;
  Image texture(8, 8, 4, 1.0f);
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x) texture.at(x, y, 3) = 0.0f;
  }
  scene.textures.push_back(texture);
  for (std::size_t m = 2; m < scene.meshes.size(); ++m) {
    Mesh& mesh = scene.meshes[m];
    mesh.material = 1;
    mesh.uvs.resize(mesh.positions.size());
    for (std::size_t v = 0; v < mesh.uvs.size(); ++v) {
      mesh.uvs[v] = {v % 3 == 1 ? 1.0f : 0.0f, v % 3 == 2 ? 1.0f : 0.0f};
    }
  }
  return scene;
}

/// 16 points within `extent`, whose normals differ by about `bend`; one in ten is not active.
TileFrame random_tile(Random& random, float extent, float bend) {
  TileFrame tile;
  const glm::vec3 middle(random(-2, 2), random(-2, 2), random(0.01f, 1.5f));
  const glm::vec3 normal = random(0, 1) < 0.3f ? glm::vec3(0, 0, 1) : random.direction();
  for (int i = 0; i < lane_count; ++i) {
    const glm::mat3 frame = tangent_frame(normalize(normal + bend * random.direction()));
    tile.active[i] = i == 0 || random() > 0.1f ? -1 : 0;
    set_lane(tile.origin, i, middle + extent * random.direction());
    set_lane(tile.tangent, i, frame[0]);
    set_lane(tile.bitangent, i, frame[1]);
    set_lane(tile.normal, i, frame[2]);
  }
  return tile;
}

struct Counts {
  long rays = 0;
  long different = 0;
  long blocked = 0;
  double difference = 0.0;
};

void compare(const TileFrame& tile, LaneMask active, const Lanes3& direction, float reach, int cell,
             TileVisibility& visibility, Counts& counts) {
  Lanes distance;
  distance.v.fill(reach);
  const Lanes expected = visibility.packets()(tile.origin, active, direction, distance);
  const Lanes found = visibility(active, direction, cell);
  for (int i = 0; i < lane_count; ++i) {
    if (!active[i]) continue;
    ++counts.rays;
    counts.blocked += expected[i] < 1.0f ? 1 : 0;
    counts.different += std::fabs(found[i] - expected[i]) > 1e-3f ? 1 : 0;
    counts.difference += double(found[i]) - double(expected[i]);
  }
}

/// Both kinds of directions from one tile.
void compare_tile(const TileFrame& tile, float reach, TileVisibility& visibility, Random& random,
                  Counts& counts) {
  for (int ray = 0; ray < 256; ++ray) {
    Lanes3 direction;
    LaneMask active = tile.active;
    const float u = random(), v = random();
    const float angle = 2 * pi * v;
    const glm::vec3 local(std::sqrt(u) * std::cos(angle), std::sqrt(u) * std::sin(angle),
                          std::sqrt(1 - u));
    for (int i = 0; i < lane_count; ++i) {
      const glm::mat3 frame(at(tile.tangent, i), at(tile.bitangent, i), at(tile.normal, i));
      set_lane(direction, i, frame * local);
    }
    EXPECT_EQ(tangent_cell(u, v), tangent_cell(local)) << u << " " << v;
    compare(tile, active, direction, reach, tangent_cell(u, v), visibility, counts);

    const glm::vec3 shared = random.direction();
    for (int i = 0; i < lane_count; ++i) {
      set_lane(direction, i, shared);
      if (dot(shared, at(tile.normal, i)) <= 0.0f) active[i] = 0;
    }
    compare(tile, active, direction, reach, cube_cell(shared), visibility, counts);
  }
}

struct Case {
  int triangles;
  float size, extent, bend, reach;
  int weight;
  long rays = 1024;  ///< as announced; few leave no time to list everything
};

TEST(TileVisibility, IsEmbrees) {
  const std::vector<Case> cases = {
      {0, 0.1f, 0.02f, 0.0f, infinite, 0},       {0, 0.1f, 0.02f, 0.05f, 0.7f, 1},
      {40, 0.3f, 0.05f, 0.0f, 0.5f, 0},          {40, 0.3f, 0.05f, 0.3f, infinite, 0},
      {40, 0.3f, 0.0f, 0.0f, 1.0f, 2},           {2000, 0.1f, 0.02f, 0.1f, 0.5f, 0},
      {2000, 0.1f, 0.02f, 0.02f, 0.5f, 1},       {20000, 0.02f, 0.01f, 0.05f, 0.3f, 0},
      {20000, 0.02f, 0.01f, 0.05f, infinite, 2}, {300, 0.1f, 0.0f, 0.2f, infinite, 0},
      {300, 0.1f, 0.0f, 0.2f, infinite, 0, 8}};
  for (const Case& c : cases) {
    const TracedScene traced(strewn_scene(c.triangles, c.size));
    const BlockerWeight weight{.weight = c.weight, .d_max_world = c.reach};
    TileVisibility visibility(traced, weight);
    Random random;
    Counts counts;
    for (int tile_index = 0; tile_index < 200; ++tile_index) {
      const TileFrame tile = random_tile(random, c.extent, c.bend);
      visibility.set_tile(tile, CellKinds::both, c.rays);
      compare_tile(tile, c.reach, visibility, random, counts);
    }
    // Rays within rounding of an edge may differ, as often one way as the other.
    EXPECT_GT(counts.blocked, counts.rays / 100);
    EXPECT_LE(counts.different, counts.rays / 200000) << c.triangles << " " << c.reach;
    EXPECT_LE(std::fabs(counts.difference), 3e-6 * double(counts.rays));
  }
}

TEST(TileVisibility, HolesAreEmbrees) {
  for (const int triangles : {40, 2000}) {
    const TracedScene masked(masked_scene(triangles, 0.2f));
    const TracedScene whole(strewn_scene(triangles, 0.2f));
    TileVisibility visibility(masked, {.weight = 0, .d_max_world = 0.8f});
    TileVisibility without_holes(whole, {.weight = 0, .d_max_world = 0.8f});
    Random random, same_random;
    Counts counts, whole_counts;
    for (int tile_index = 0; tile_index < 200; ++tile_index) {
      const TileFrame tile = random_tile(random, 0.02f, 0.05f);
      random_tile(same_random, 0.02f, 0.05f);
      visibility.set_tile(tile, CellKinds::both, 1024);
      without_holes.set_tile(tile, CellKinds::both, 1024);
      compare_tile(tile, 0.8f, visibility, random, counts);
      compare_tile(tile, 0.8f, without_holes, same_random, whole_counts);
    }
    EXPECT_LE(counts.different, counts.rays / 200000) << triangles;
    EXPECT_LT(counts.blocked, whole_counts.blocked) << triangles;
    EXPECT_GT(counts.blocked, counts.rays / 100);
  }
}

TEST(TileVisibility, ListsAreUsed) {
  // Above a floor nothing can be met, beside one wall the wall alone.
  const TracedScene traced(SceneBuilder()
                               .add(quad({-4, -4, 0}, {8, 0, 0}, {0, 8, 0}))
                               .add(quad({-4, 2, 0}, {8, 0, 0}, {0, 0, 4}))
                               .build());
  TileFrame tile;
  for (int i = 0; i < lane_count; ++i) {
    tile.active[i] = -1;
    set_lane(tile.origin, i, {0.01f * float(i), 0, 10.0f * 1e-4f});
    set_lane(tile.tangent, i, {1, 0, 0});
    set_lane(tile.bitangent, i, {0, 1, 0});
    set_lane(tile.normal, i, {0, 0, 1});
  }
  TileCandidates candidates(traced.tree());
  const auto listed = [&](float reach) {
    candidates.fill(tile, reach, 1e-5f, CellKinds::both, 1000);
    int sum = 0;
    for (int cell = 0; cell < direction_cells; ++cell) {
      EXPECT_FALSE(candidates.list(cell).many) << cell;
      sum += candidates.list(cell).count;
    }
    return sum;
  };
  EXPECT_EQ(listed(1.0f), 0) << "the wall is 2 away";
  const int beside_wall = listed(3.0f);
  EXPECT_GT(beside_wall, 0);
  EXPECT_LT(beside_wall, direction_cells);
}

}  // namespace
}  // namespace occlab::test
