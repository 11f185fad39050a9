#pragma once

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
  int texture(std::size_t gltf_texture, const std::string& material_name);

  const GltfFile* file_;
  Scene* scene_;
  std::map<std::size_t, int> loaded_materials_;  // glTF index -> Scene::materials
  std::map<std::size_t, int> loaded_images_;     // glTF image -> Scene::textures
  std::optional<int> default_material_;
  std::vector<UvSource> uv_sources_;
};

/// One primitive of a glTF mesh, or nothing if it has no triangles (points and lines).
std::optional<Mesh> load_primitive(const GltfFile& file, const JsonValue& primitive,
                                   const std::string& mesh_name, MaterialTable& materials,
                                   std::vector<std::string>& warnings);

}  // namespace occlab
