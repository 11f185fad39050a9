// The G-buffer against intersections of the pixel centres' rays, computed here in double precision.

#include "renderers/gl/gbuffer.h"

#include <gtest/gtest.h>

#include "tests/gpu/gpu_frame.h"

namespace occlab::test {
namespace {

const View oblique = look_at({2, 1.5f, 3}, {0, 0.25f, 0}, 0.7f, 60, 37);

/// View-space direction through a pixel's centre, z = -1: the convention of view.h.
glm::dvec3 pixel_ray(const View& view, int x, int y) {
  const double focal = 0.5 * view.height / std::tan(0.5 * double(view.camera.yfov));
  return {(x + 0.5 - 0.5 * view.width) / focal, (0.5 * view.height - y - 0.5) / focal, -1.0};
}

struct Plane {
  glm::dvec3 point;
  glm::dvec3 normal;
};

Plane in_view(const View& view, glm::vec3 point, glm::vec3 normal) {
  const glm::mat4 view_from_world = view.view_from_world();
  return {glm::vec3(view_from_world * glm::vec4(point, 1)),
          glm::vec3(view_from_world * glm::vec4(normal, 0))};
}

glm::dvec3 intersection(const Plane& plane, glm::dvec3 ray) {
  return ray * (glm::dot(plane.point, plane.normal) / glm::dot(ray, plane.normal));
}

TEST(GBuffer, PlanesArePreciseAtPixelCentres) {
  const TestFrame frame(floor_and_tall_wall(5.0f), oblique, constant_environment(glm::vec3(1)));
  const GBufferImages& surface = frame.surface();
  const Plane floor = in_view(oblique, {0, 0, 0}, {0, 1, 0});
  const Plane wall = in_view(oblique, {0, 0, 0}, {1, 0, 0});
  const glm::mat4 world_from_view = oblique.camera.world_from_camera;
  int floors = 0, walls = 0, background = 0;
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) {
      const glm::dvec3 ray = pixel_ray(oblique, x, y);
      const glm::dvec3 on_floor = intersection(floor, ray);
      const glm::dvec3 on_wall = intersection(wall, ray);
      const glm::vec3 at_wall(world_from_view * glm::vec4(glm::vec3(on_wall), 1));
      const glm::vec3 at_floor(world_from_view * glm::vec4(glm::vec3(on_floor), 1));
      const bool wall_first = on_wall.z < 0 && at_wall.y > 0;
      // Pixels whose centre is within rounding of an edge may fall to either side.
      if (std::abs(at_wall.y) < 1e-4f || std::abs(at_wall.y - 5) < 1e-4f) continue;
      const bool hit = wall_first ? at_wall.y < 5 && std::abs(at_wall.z) < 5
                                  : on_floor.z < 0 && at_floor.x < 5 && std::abs(at_floor.z) < 5;
      ASSERT_EQ(surface.mask.at(x, y), hit ? 1.0f : 0.0f) << x << " " << y;
      if (!hit) {
        ++background;
        EXPECT_EQ(pixel3(surface.position_view, x, y), glm::dvec3(0));
        EXPECT_EQ(pixel3(surface.normal_view, x, y), glm::dvec3(0));
        EXPECT_EQ(pixel3(surface.albedo, x, y), glm::dvec3(0));
        continue;
      }
      (wall_first ? walls : floors) += 1;
      const Plane& plane = wall_first ? wall : floor;
      const glm::dvec3 expected = wall_first ? on_wall : on_floor;
      const double depth = glm::length(expected);
      // Rasterisation interpolates in single precision.
      EXPECT_LT(glm::length(pixel3(surface.position_view, x, y) - expected), 2e-5 * depth);
      EXPECT_LT(glm::length(pixel3(surface.normal_view, x, y) - plane.normal), 1e-6);
      EXPECT_LT(glm::length(pixel3(surface.geometric_normal_view, x, y) - plane.normal), 2e-3);
    }
  }
  EXPECT_GT(floors, 300);
  EXPECT_GT(walls, 300);
  EXPECT_GT(background, 20);
}

TEST(GBuffer, RowZeroIsTheTopAndColumnZeroTheLeft) {
  const Scene scene = SceneBuilder()
                          .add(quad({0.2f, 0.1f, -5}, {0.5f, 0, 0}, {0, 0.6f, 0}))
                          .material({1, 0, 0})
                          .add(quad({-0.7f, -0.7f, -5}, {0.5f, 0, 0}, {0, 0.6f, 0}))
                          .material({0, 0, 1})
                          .build();
  View view;
  view.camera.yfov = 2.0f * std::atan(1.0f / 5.0f);  // one unit either way at z = -5
  view.width = view.height = 20;
  const TestFrame frame(scene, view, constant_environment(glm::vec3(1)));
  const Image& albedo = frame.surface().albedo;
  // Upper right: columns 10 + 2 to 10 + 7, rows 10 - 7 to 10 - 1.
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      const bool red = x >= 12 && x < 17 && y >= 3 && y < 9;
      const bool blue = x >= 3 && x < 8 && y >= 11 && y < 17;
      EXPECT_EQ(pixel3(albedo, x, y), glm::dvec3(red, 0, blue)) << x << " " << y;
    }
  }
}

TEST(GBuffer, SurfacesAreTwoSidedAndTheNearestWins) {
  // Wound clockwise, and with a vertex normal that points away from the viewer.
  Mesh back = quad({-1, -1, -4}, {0, 2, 0}, {2, 0, 0});
  for (glm::vec3& n : back.normals) n = {0, 0, -1};
  for (const bool far_first : {false, true}) {
    const Mesh far = quad({-1, -1, -6}, {2, 0, 0}, {0, 2, 0});
    View view;
    view.camera.yfov = 0.2f;
    view.width = view.height = 8;
    SceneBuilder builder;
    builder.add(far_first ? far : back).add(far_first ? back : far);
    const TestFrame frame(builder.build(), view, constant_environment(glm::vec3(1)));
    EXPECT_NEAR(frame.surface().position_view.at(3, 3, 2), -4.0f, 1e-5f);
    EXPECT_NEAR(frame.surface().normal_view.at(3, 3, 2), 1.0f, 1e-6f);
    EXPECT_NEAR(frame.surface().geometric_normal_view.at(3, 3, 2), 1.0f, 1e-6f);
  }
}

TEST(GBuffer, InstancesMirrorsAndNonUniformScales) {
  // A slanted quad, mirrored, stretched and turned: normals go with the inverse transpose.
  const Mesh mesh = quad({-0.5f, -0.5f, 0}, {1, 0, 0.5f}, {0, 1, 0.25f});
  const glm::mat4 place = glm::translate(glm::mat4(1.0f), {0, 0, -4}) *
                          glm::rotate(glm::mat4(1.0f), 0.4f, glm::vec3(1, 2, 3)) *
                          glm::scale(glm::mat4(1.0f), glm::vec3(-3, 1, 2));
  const glm::mat4 beside = glm::translate(glm::mat4(1.0f), {50, 0, 0});
  View view;
  view.camera.yfov = 0.15f;
  view.width = view.height = 9;
  const TestFrame frame(SceneBuilder().add(mesh, place).instance(0, beside).build(), view,
                        constant_environment(glm::vec3(1)));
  const glm::vec3 u(place * glm::vec4(1, 0, 0.5f, 0)), v(place * glm::vec4(0, 1, 0.25f, 0));
  const Plane plane{glm::vec3(place * glm::vec4(0, 0, 0.375f, 1)),
                    glm::normalize(glm::cross(u, v))};
  const double side = plane.normal.z > 0 ? 1.0 : -1.0;
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 9; ++x) {
      ASSERT_EQ(frame.surface().mask.at(x, y), 1.0f);
      EXPECT_LT(glm::length(pixel3(frame.surface().normal_view, x, y) - side * plane.normal), 1e-5);
      EXPECT_LT(glm::length(pixel3(frame.surface().position_view, x, y) -
                            intersection(plane, pixel_ray(view, x, y))),
                1e-4);
    }
  }
}

TEST(GBuffer, AlbedoIsTextureTimesFactorWithRowZeroAtVZero) {
  Scene scene = SceneBuilder().add(quad({-1, -1, -5}, {2, 0, 0}, {0, 2, 0})).build();
  // 2x2 texels: red, green; blue, white. v = 0 is their top row and the quad's lower edge.
  Image texture(2, 2, 3);
  texture.at(0, 0, 0) = texture.at(1, 0, 1) = texture.at(0, 1, 2) = 1.0f;
  for (int c = 0; c < 3; ++c) texture.at(1, 1, c) = 1.0f;
  scene.textures.push_back(texture);
  scene.materials[0].albedo = {0.5f, 0.25f, 1.0f};
  scene.materials[0].albedo_texture = 0;
  View view;
  view.camera.yfov = 2.0f * std::atan(1.0f / 5.0f);
  view.width = view.height = 16;
  const TestFrame frame(scene, view, constant_environment(glm::vec3(1)));
  // Texel centres are at a quarter and three quarters; pixels 3 and 4 straddle the first.
  for (const int low : {3, 4}) {
    const int high = low + 8;
    const auto mixed = [&](int x, int y) { return pixel3(frame.surface().albedo, x, y); };
    EXPECT_GT(mixed(low, high).x, 0.4);   // lower left: red x .5
    EXPECT_GT(mixed(high, high).y, 0.2);  // lower right: green x .25
    EXPECT_GT(mixed(low, low).z, 0.8);    // upper left: blue
    EXPECT_GT(mixed(high, low).x, 0.4);   // upper right: white x factor
    EXPECT_LT(mixed(low, high).y, 0.05);
  }
}

TEST(GBuffer, HalfFloatTargetsHaveElevenBits) {
  // OpenGL leaves the rounding open; llvmpipe truncates, so the bound is a whole last bit.
  const TestFrame frame(floor_and_tall_wall(5.0f), oblique, constant_environment(glm::vec3(1)));
  const GBufferImages half = download(frame.frame().gbuffer(GBufferBits::float16));
  const GBufferImages& full = frame.surface();
  EXPECT_EQ(half.mask, full.mask);
  int different = 0;
  for (std::size_t i = 0; i < full.position_view.values().size(); ++i) {
    const float p = full.position_view.values()[i];
    EXPECT_LE(std::abs(half.position_view.values()[i] - p), std::abs(p) * 0x1p-10f + 1e-7f);
    const float n = full.normal_view.values()[i];
    EXPECT_LE(std::abs(half.normal_view.values()[i] - n), std::abs(n) * 0x1p-10f + 1e-7f);
    different += half.position_view.values()[i] != p ? 1 : 0;
  }
  EXPECT_GT(different, 1000) << "16 bits were asked for and 32 delivered";
}

}  // namespace
}  // namespace occlab::test
