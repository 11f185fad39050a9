// load_scene: containers as they are, or JSON and binary chunk of a container that is put together
// here, so that changes of their lengths reach the loader.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "renderers/scene/error.h"
#include "renderers/scene/limits.h"
#include "renderers/scene/parallel.h"
#include "renderers/scene/scene.h"
#include "tests/fuzz/fuzz_input.h"

namespace occlab::fuzz {
namespace {

std::string u32(std::size_t value) {
  std::string bytes(4, '\0');
  for (std::size_t i = 0; i < 4; ++i) bytes[i] = char((value >> (8 * i)) & 0xff);
  return bytes;
}

std::string container(const TwoParts& parts) {
  const std::size_t size = 12 + 8 + parts.first.size() + 8 + parts.second.size();
  std::string bytes = "glTF" + u32(2) + u32(size) + u32(parts.first.size()) + "JSON";
  bytes.append(parts.first);
  bytes += u32(parts.second.size()) + std::string("BIN\0", 4);
  bytes.append(parts.second);
  return bytes;
}

template <typename Vector>
bool finite(const Vector& vector) {
  for (int i = 0; i < Vector::length(); ++i) {
    if (!std::isfinite(vector[i])) return false;
  }
  return true;
}

bool finite(const glm::mat4& matrix) {
  return finite(matrix[0]) && finite(matrix[1]) && finite(matrix[2]) && finite(matrix[3]);
}

void check(const Mesh& mesh, const Scene& scene) {
  const auto all_finite = [](const auto& v) { return finite(v); };
  require(std::ranges::all_of(mesh.positions, all_finite));
  require(std::ranges::all_of(mesh.normals, all_finite));
  require(std::ranges::all_of(mesh.uvs, all_finite));
  require(mesh.normals.size() == mesh.positions.size());
  require(mesh.uvs.empty() || mesh.uvs.size() == mesh.positions.size());
  const Material& material = scene.materials.at(std::size_t(mesh.material));
  require(!material.albedo_texture || !mesh.uvs.empty());
  require(mesh.indices.size() % 3 == 0);
  require(std::ranges::all_of(mesh.indices, [&](auto i) { return i < mesh.positions.size(); }));
  require(mesh.material >= 0 && std::size_t(mesh.material) < scene.materials.size());
}

void check(const Scene& scene) {
  require(scene.triangle_count() > 0 && !scene.cameras.empty());
  require(finite(scene.bounds_min) && finite(scene.bounds_max));
  for (const Mesh& mesh : scene.meshes) check(mesh, scene);
  for (const Instance& instance : scene.instances) {
    require(std::size_t(instance.mesh) < scene.meshes.size());
    require(finite(instance.world_from_object));
  }
  for (const Material& material : scene.materials) {
    require(finite(material.albedo));
    require(!material.albedo_texture ||
            std::size_t(*material.albedo_texture) < scene.textures.size());
    require(material.alpha >= 0.0f && material.alpha <= 1.0f);
    require(!material.alpha_cutoff || *material.alpha_cutoff >= 0.0f);
  }
  for (const Image& texture : scene.textures) {
    require(!texture.empty() && (texture.channels() == 3 || texture.channels() == 4));
    require(std::ranges::all_of(texture.values(), [](float v) { return std::isfinite(v); }));
  }
  for (const Light& light : scene.lights) {
    require(finite(light.position_world) && finite(light.direction_world));
    require(finite(light.intensity));
  }
  for (const Camera& camera : scene.cameras) {
    require(finite(camera.world_from_camera));
    require(camera.yfov > 0.0f && camera.aspect > 0.0f && camera.znear > 0.0f);
    require(std::isfinite(camera.zfar) && camera.zfar > camera.znear);
  }
}

}  // namespace
}  // namespace occlab::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace occlab;
  static const fuzz::Folder folder;
  static const bool set_up = [] {
    set_thread_count(1);
    set_limits(
        "file_bytes=1048576,json_values=20000,vertices=100000,triangles=100000,instances=10000,"
        "texture_pixels=65536,texture_bytes=4194304");
    return true;
  }();
  const std::string_view input = fuzz::text_of(data, size);
  const bool whole = input.starts_with("glTF");
  const auto file = folder.write(
      "scene.glb", set_up && whole ? std::string(input) : fuzz::container(fuzz::split(input)));
  try {
    fuzz::check(load_scene(file));
  } catch (const InputError&) {
  }
  return 0;
}
