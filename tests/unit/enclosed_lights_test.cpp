// Winding numbers against their closed forms, and which lights count as shut in.

#include "renderers/scene/enclosed_lights.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "tests/analytic/built_scenes.h"

namespace occlab::test {
namespace {

constexpr glm::vec3 eye(0, 0, 10);

Light lamp_at(glm::vec3 position) { return {.name = "lamp", .position_world = position}; }

std::vector<EnclosedLight> enclosed(Scene scene, const Light& light, glm::vec3 seen_from = eye) {
  scene.lights = {light};
  return enclosed_lights(scene, seen_from);
}

Mesh turned_inside_out(Mesh mesh) {
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
  }
  return mesh;
}

TEST(WindingNumber, IsOneInsideOfAClosedMeshAndZeroOutside) {
  const Mesh ball = sphere_part({0, 0, 0}, 1.0, 0.0, pi_d, 12);
  for (const glm::dvec3& inside :
       {glm::dvec3(0), glm::dvec3(0.9, 0, 0), glm::dvec3(0, 0.3, -0.8)}) {
    EXPECT_NEAR(std::abs(winding_number(ball, inside)), 1.0, 1e-6);
    EXPECT_NEAR(winding_number(ball, inside) + winding_number(turned_inside_out(ball), inside), 0.0,
                1e-12);
  }
  for (const glm::dvec3& outside : {glm::dvec3(1.1, 0, 0), glm::dvec3(5, 5, 5)}) {
    EXPECT_NEAR(winding_number(ball, outside), 0.0, 1e-6);
  }
}

TEST(WindingNumber, OfAnOpenMeshIsTheShareOfDirectionsThatItCovers) {
  // A cap up to the polar angle theta covers (1 - cos theta)/2 of them, seen from its centre.
  for (const double theta : {0.5, 1.0, 2.0}) {
    const Mesh cap = sphere_part({0, 0, 0}, 1.0, 0.0, theta, 60);
    EXPECT_NEAR(std::abs(winding_number(cap, glm::dvec3(0))), 0.5 * (1.0 - std::cos(theta)), 1e-3);
  }
  // One face of a cube.
  const Mesh face = quad({-1, -1, -1}, {2, 0, 0}, {0, 2, 0});
  EXPECT_NEAR(std::abs(winding_number(face, glm::dvec3(0))), 1.0 / 6.0, 1e-12);
}

TEST(EnclosedLights, AreThoseInsideOfAClosedMesh) {
  const Scene box = SceneBuilder().add_box({-1, -1, -1}, {1, 1, 1}).build();
  const auto found = enclosed(box, lamp_at({0.5f, 0, 0}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found.front().light, "lamp");
  EXPECT_EQ(found.front().mesh, "quad");
  EXPECT_TRUE(enclosed(box, lamp_at({0, 2, 0})).empty());
  Light sun = lamp_at({0, 0, 0});
  sun.type = LightType::directional;
  EXPECT_TRUE(enclosed(box, sun).empty()) << "a sun is nowhere";
  Light spot = lamp_at({0, 0, 0});
  spot.type = LightType::spot;
  EXPECT_EQ(enclosed(box, spot).size(), 1u);
}

TEST(EnclosedLights, AreShutInWhicheverSideTheTrianglesFace) {
  const Mesh ball = sphere_part({0, 0, 0}, 1.0, 0.0, pi_d, 12);
  for (const Mesh& mesh : {ball, turned_inside_out(ball)}) {
    EXPECT_EQ(enclosed(SceneBuilder().add(mesh).build(), lamp_at({0, 0, 0})).size(), 1u);
  }
}

TEST(EnclosedLights, AreNotThoseOfTheEyesOwnRoom) {
  const Scene room = SceneBuilder().add_box({-1, -1, -1}, {1, 1, 1}).build();
  EXPECT_TRUE(enclosed(room, lamp_at({0.5f, 0, 0}), {-0.5f, 0, 0}).empty());
  const Scene lamp_in_a_ball = SceneBuilder()
                                   .add_box({-1, -1, -1}, {1, 1, 1})
                                   .add(sphere_part({0.5, 0, 0}, 0.2, 0.0, pi_d, 8))
                                   .build();
  const auto found = enclosed(lamp_in_a_ball, lamp_at({0.5f, 0, 0}), {-0.5f, 0, 0});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found.front().mesh, "revolution");
}

TEST(EnclosedLights, ShineOutOfWhatIsOpenOrHasHoles) {
  const Mesh shade = sphere_part({0, 0, 0}, 1.0, 0.3, pi_d - 0.3, 12);
  EXPECT_TRUE(enclosed(SceneBuilder().add(shade).build(), lamp_at({0, 0, 0})).empty());
  Scene lantern = SceneBuilder().add(sphere_part({0, 0, 0}, 1.0, 0.0, pi_d, 12)).build();
  lantern.materials.front().alpha_cutoff = 0.5f;
  EXPECT_TRUE(enclosed(lantern, lamp_at({0, 0, 0})).empty());
}

TEST(EnclosedLights, AreFoundAtEveryPlaceOfAMesh) {
  const glm::mat4 turned = glm::rotate(glm::mat4(1.0f), 0.7f, glm::vec3(1, 2, 3));
  const glm::mat4 squeezed = glm::scale(turned, glm::vec3(0.2f, -1.0f, 3.0f));  // and mirrored
  const glm::mat4 moved = glm::translate(glm::mat4(1.0f), glm::vec3(4, 0, 0)) * squeezed;
  Scene scene = SceneBuilder()
                    .add(sphere_part({0, 0, 0}, 1.0, 0.0, pi_d, 12), moved)
                    .instance(0, glm::translate(glm::mat4(1.0f), glm::vec3(-4, 0, 0)))
                    .build();
  const auto place = [&](glm::vec3 object) { return glm::vec3(moved * glm::vec4(object, 1.0f)); };
  EXPECT_EQ(enclosed(scene, lamp_at(place({0.5f, 0.5f, 0.5f}))).size(), 1u);
  EXPECT_TRUE(enclosed(scene, lamp_at(place({0.8f, 0.8f, 0.8f}))).empty());
  EXPECT_EQ(enclosed(scene, lamp_at({-4, 0.5f, 0})).size(), 1u);
  EXPECT_TRUE(enclosed(scene, lamp_at({0, 0.5f, 0})).empty());
}

}  // namespace
}  // namespace occlab::test
