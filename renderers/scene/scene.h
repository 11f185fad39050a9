#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "renderers/scene/image.h"

namespace occlab {

/// glTF space everywhere: right-handed, +Y up, lengths in scene units (Blender metres).

/// How a surface texture is read between and beyond its texels (shared/surface_texture.h).
struct TextureSampling {
  int wrap_u = 0;  ///< wrap_repeat, ...
  int wrap_v = 0;
  bool nearest = false;  ///< the nearest texel; else bilinear
};

/// Lambertian and two-sided: both sides of a triangle are seen, block light and reflect the same,
/// whether or not the file says `doubleSided`.
struct Material {
  std::string name;
  glm::vec3 albedo{0.8f};             ///< linear RGB reflectance rho, in [0, 1]
  std::optional<int> albedo_texture;  ///< index into Scene::textures, multiplied with `albedo`
  TextureSampling sampling = {};
  float alpha = 1.0f;  ///< in [0, 1], multiplied with the texture's alpha
  /// Where alpha is below it, there is no surface; without one alpha is not looked at.
  std::optional<float> alpha_cutoff = std::nullopt;
};

/// Triangles that share one material, in object space.
struct Mesh {
  std::string name;
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;      ///< unit, one a vertex
  std::vector<glm::vec2> uvs;          ///< empty, or one a vertex; v = 0 is the texture's top row
  std::vector<std::uint32_t> indices;  ///< three a triangle, counter-clockwise from outside
  int material = 0;                    ///< index into Scene::materials
};

struct Instance {
  int mesh = 0;  ///< index into Scene::meshes
  glm::mat4 world_from_object{1.0f};
};

enum class LightType { point, directional, spot };

/// A punctual light (KHR_lights_punctual, Blender's COMPAT units).
struct Light {
  std::string name;
  LightType type = LightType::point;
  glm::vec3 position_world{0.0f};                ///< point and spot
  glm::vec3 direction_world{0.0f, -1.0f, 0.0f};  ///< where the light travels; directional and spot
  /// Linear RGB: radiant intensity I (W/sr) of point and spot, so that E = I / d^2; irradiance
  /// E_perp (W/m^2) of directional.
  glm::vec3 intensity{0.0f};
  float inner_cone_angle = 0.0f;  ///< spot, radians
  float outer_cone_angle = 0.7853982f;
};

/// A pinhole camera; the film's centre is on its -Z axis.
struct Camera {
  std::string name;
  glm::mat4 world_from_camera{1.0f};
  float yfov = 0.8f;  ///< full vertical field of view, radians
  float aspect = 16.0f / 9.0f;
  float znear = 0.1f;
  float zfar = 1000.0f;
};

/// The world HDRI that scenes/export.py put into the scene's extras (scenes/FORMAT.md).
struct SceneEnvironment {
  std::string probe;  ///< a probe's name, or a path relative to the scene file
  float rotation_degrees = 0.0f;
  float strength = 1.0f;
};

struct Scene {
  std::string name;
  std::filesystem::path path;
  std::vector<Mesh> meshes;
  std::vector<Instance> instances;
  std::vector<Material> materials;
  std::vector<Image> textures;  ///< linear RGB; a fourth channel is alpha, not multiplied in
  std::vector<Light> lights;
  std::vector<Camera> cameras;
  std::optional<SceneEnvironment> environment;
  std::vector<std::string> warnings;  ///< what the file holds and occlab does not use
  glm::vec3 bounds_min{0.0f};         ///< of all instances, world space
  glm::vec3 bounds_max{0.0f};

  std::size_t triangle_count() const;  ///< instances counted
  float bounding_radius() const { return 0.5f * glm::length(bounds_max - bounds_min); }
};

/// Reads a .glb or .gltf. Throws InputError naming the file and what is wrong: missing, corrupt, no
/// camera, no triangles, non-finite vertices, indices out of range, a feature without which the
/// picture would be wrong.
Scene load_scene(const std::filesystem::path& path);

/// The camera called `name`; an empty name means the first. Throws InputError listing the cameras.
const Camera& find_camera(const Scene& scene, const std::string& name);

}  // namespace occlab
