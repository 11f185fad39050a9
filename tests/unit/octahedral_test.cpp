// renderers/shared/octahedral.h, and the map that SSDO reads the probe from.
#include "renderers/shared/octahedral.h"

#include <gtest/gtest.h>

#include <random>

#include "renderers/methods/octahedral_map.h"
#include "renderers/shared/equirect.h"
#include "tests/analytic/built_scenes.h"

namespace occlab {
namespace {

glm::vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<float> normal;
  return glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
}

TEST(Octahedral, PointAndUvAreInverse) {
  std::mt19937 random(1);
  for (int i = 0; i < 10000; ++i) {
    const glm::vec3 d = random_direction(random);
    const glm::vec2 uv = octahedral_uv(d);
    EXPECT_GE(std::min(uv.x, uv.y), 0.0f);
    EXPECT_LE(std::max(uv.x, uv.y), 1.0f);
    EXPECT_LT(glm::distance(glm::normalize(octahedral_point(uv)), d), 2e-6f);
  }
  EXPECT_EQ(octahedral_uv({0, 1, 0}), glm::vec2(0.5f));
  EXPECT_EQ(octahedral_uv({0, 0, 3}), glm::vec2(0.5f, 1.0f));
}

/// The integral of f(texel, direction) over the octahedral map.
template <typename F>
glm::dvec3 integral(const Image& map, const F& weight) {
  glm::dvec3 sum(0.0);
  const double cell = 4.0 / double(map.width()) / double(map.width());
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x) {
      const glm::dvec3 point(
          octahedral_point(glm::vec2(float(x) + 0.5f, float(y) + 0.5f) / float(map.width())));
      // A cell of the (x, z) plane, seen from the origin: the octahedron's faces have the normal
      // (1, 1, 1)/sqrt(3), at a distance of 1/sqrt(3).
      const double solid_angle = cell / std::pow(glm::length(point), 3.0);
      const auto texel = map.pixel(x, y);
      sum +=
          glm::dvec3(texel[0], texel[1], texel[2]) * (solid_angle * weight(glm::normalize(point)));
    }
  }
  return sum;
}

TEST(Octahedral, MapKeepsTheProbesIrradiance) {
  // A small sun over a bright sky: E of both, from many sides.
  const Environment probe = test::probe_of(256, [](glm::vec3 d) {
    const bool sun = glm::dot(d, glm::normalize(glm::vec3(0.5f, 0.7f, 0.3f))) > 0.999f;
    return sun ? glm::vec3(3000, 2700, 2000) : glm::vec3(0.3f, 0.5f + 0.4f * d.y, 1.0f);
  });
  const Image map = octahedral_map(probe);
  EXPECT_EQ(map.width(), 512);  // for the sun's outline
  std::mt19937 random(2);
  for (int i = 0; i < 20; ++i) {
    const glm::dvec3 n(random_direction(random));
    const auto lobe = [&](glm::dvec3 d) { return std::max(0.0, glm::dot(n, d)); };
    const glm::dvec3 found = integral(map, lobe);
    glm::dvec3 expected(0.0);
    glm::dvec3 everything(0.0);
    const Image& texels = probe.texels;
    for (int y = 0; y < texels.height(); ++y) {
      for (int x = 0; x < texels.width(); ++x) {
        const glm::vec2 uv((float(x) + 0.5f) / float(texels.width()),
                           (float(y) + 0.5f) / float(texels.height()));
        const glm::dvec3 d(equirect_direction(uv));
        const double solid_angle = 2.0 * double(pi) * double(pi) * std::sqrt(1.0 - d.y * d.y) /
                                   double(texels.pixel_count());
        const auto texel = texels.pixel(x, y);
        const glm::dvec3 light = glm::dvec3(texel[0], texel[1], texel[2]) * solid_angle;
        expected += light * lobe(d);
        everything += light;
      }
    }
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 1e-3 * everything[c]) << i;
  }
}

TEST(Octahedral, MapIsAsSmallAsTheProbeIsSmooth) {
  Environment probe = test::probe_of(256, [](glm::vec3) { return glm::vec3(1, 2, 3); });
  EXPECT_EQ(octahedral_side(probe), 512);
  for (const float sigma : {0.5f, 1.0f, 2.0f, 4.0f, 8.0f, 16.0f}) {
    probe.blur_degrees = sigma;
    const int side = octahedral_side(probe);
    const double texel_degrees = std::sqrt(41252.96 / (double(side) * side));
    EXPECT_TRUE(texel_degrees <= 0.1 * double(sigma) || side == 2048) << sigma;
    EXPECT_TRUE(2.0 * texel_degrees > 0.1 * double(sigma) || side == 64) << sigma;
  }
}

TEST(Octahedral, TheLastTexelEndsTheMap) {
  for (int map = 64; map <= 8192; map *= 2) {
    EXPECT_EQ(octahedral_texel({0.0f, 1.0f}, map), glm::ivec2(0, map - 1));
    EXPECT_EQ(octahedral_texel(glm::vec2(0.5f), map), glm::ivec2(map / 2 - 1));
    EXPECT_EQ(octahedral_texel(glm::vec2(0.5f + 1.0f / float(map)), map), glm::ivec2(map / 2));
  }
}

}  // namespace
}  // namespace occlab
