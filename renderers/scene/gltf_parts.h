#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "renderers/scene/gltf_file.h"
#include "renderers/scene/scene.h"

namespace occlab {

/// Where a material's texture coordinates come from: uv' = transform (u, v, 1).
struct UvSource {
  std::string attribute;  ///< such as "TEXCOORD_0"; empty: the material has no texture
  glm::mat3 transform{1.0f};
};

/// Scene::materials and Scene::textures, read as meshes ask for them, so that nothing unused is
/// decoded.
class MaterialTable {
 public:
  MaterialTable(const GltfFile& file, Scene& scene) : file_(&file), scene_(&scene) {}

  /// Index into Scene::materials of a primitive's material; the default material if it has none.
  int material(const std::optional<JsonValue>& primitive_material);
  const UvSource& uv_source(int material) const { return uv_sources_[std::size_t(material)]; }

 private:
  void read(const JsonValue& json);
  /// Also sets the material's sampling.
  int texture(std::size_t gltf_texture, Material& material);

  const GltfFile* file_;
  Scene* scene_;
  std::map<std::size_t, int> loaded_materials_;  // glTF index -> Scene::materials
  std::map<std::size_t, int> loaded_images_;     // glTF image -> Scene::textures
  std::optional<int> default_material_;
  std::vector<UvSource> uv_sources_;
  std::uint64_t textures_bytes_ = 0;  // in memory
};

/// A node's own transform, from its matrix or its translation, rotation and scale.
glm::dmat4 local_transform(const JsonValue& node);

/// Throws InputError if an element is beyond the range of float.
void require_float_range(const JsonValue& node, const glm::dmat4& world);

/// Whether surface normals can be turned by it: in floats, as it will be done.
bool is_invertible(const glm::mat3& matrix);

/// A camera has a place and an orientation; a scale inherited from its parents means nothing.
glm::dmat4 camera_transform(const JsonValue& node, const glm::dmat4& world);

/// What the meshes read so far hold.
struct GeometryTotals {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
};

/// One primitive of a glTF mesh, or nothing if it has no triangles (points and lines). Adds to the
/// totals, and throws InputError if they pass their limits, before anything is read.
std::optional<Mesh> load_primitive(const GltfFile& file, const JsonValue& primitive,
                                   const std::string& mesh_name, MaterialTable& materials,
                                   GeometryTotals& totals, std::vector<std::string>& warnings);

}  // namespace occlab
