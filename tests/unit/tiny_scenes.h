#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "renderers/scene/error.h"
#include "renderers/scene/scene.h"
#include "renderers/scene/temporary_folder.h"

namespace occlab::test {

inline void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
  std::filesystem::remove(path);  // rewriting a file in place may wait for the disk
  std::ofstream(path, std::ios::binary) << bytes;
}

inline std::string read_bytes(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The bytes of values, as they lie in a glTF buffer.
template <typename T>
std::string bytes_of(const std::vector<T>& values) {
  static_assert(std::endian::native == std::endian::little);
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

/// A glTF file in the making: its JSON, open to every kind of damage, and one binary buffer.
struct TinyGltf {
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}};
  std::string binary;

  /// Adds `bytes` as a buffer view and returns its index.
  int add_view(const std::string& bytes) {
    auto& views = json["bufferViews"];
    views.push_back({{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}});
    binary += bytes;
    binary.resize((binary.size() + 3) / 4 * 4);
    return int(views.size()) - 1;
  }

  int add_accessor(const std::string& bytes, int component_type, const std::string& type,
                   std::size_t count) {
    auto& accessors = json["accessors"];
    accessors.push_back({{"bufferView", add_view(bytes)},
                         {"componentType", component_type},
                         {"type", type},
                         {"count", count}});
    return int(accessors.size()) - 1;
  }

  int add_vec3(const std::vector<glm::vec3>& values) {
    return add_accessor(bytes_of(values), 5126, "VEC3", values.size());
  }
  int add_vec2(const std::vector<glm::vec2>& values) {
    return add_accessor(bytes_of(values), 5126, "VEC2", values.size());
  }
  int add_indices(const std::vector<std::uint16_t>& values) {
    return add_accessor(bytes_of(values), 5123, "SCALAR", values.size());
  }

  /// Adds a node to the scene's roots and returns its index.
  int add_node(const nlohmann::json& node) {
    auto& nodes = json["nodes"];
    nodes.push_back(node);
    json["scenes"][0]["nodes"].push_back(nodes.size() - 1);
    return int(nodes.size()) - 1;
  }

  std::string glb() const {
    nlohmann::json complete = json;
    if (!binary.empty()) complete["buffers"] = {{{"byteLength", binary.size()}}};
    std::string text = complete.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    const auto u32 = [](std::size_t value) {
      return bytes_of(std::vector<std::uint32_t>{std::uint32_t(value)});
    };
    const std::size_t total = 12 + 8 + text.size() + (binary.empty() ? 0 : 8 + binary.size());
    std::string bytes = "glTF" + u32(2) + u32(total) + u32(text.size()) + "JSON" + text;
    if (!binary.empty()) bytes += u32(binary.size()) + std::string("BIN\0", 4) + binary;
    return bytes;
  }

  std::filesystem::path write(const std::filesystem::path& path) const {
    write_bytes(path, glb());
    return path;
  }
};

/// One triangle (0,0,0), (1,0,0), (0,1,0) with normals +Z, and the camera "eye" at (0,0,3).
/// Accessors: 0 positions, 1 normals, 2 indices. Nodes: 0 "thing", 1 "eye".
inline TinyGltf tiny_triangle() {
  TinyGltf gltf;
  const int positions = gltf.add_vec3({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  const int normals = gltf.add_vec3({{0, 0, 1}, {0, 0, 1}, {0, 0, 1}});
  const int indices = gltf.add_indices({0, 1, 2});
  gltf.json["materials"] = {
      {{"name", "grey"},
       {"pbrMetallicRoughness",
        {{"baseColorFactor", {0.25, 0.5, 0.75, 1.0}}, {"metallicFactor", 0.0}}}}};
  gltf.json["meshes"] = {{{"name", "triangle"},
                          {"primitives",
                           {{{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}},
                             {"indices", indices},
                             {"material", 0}}}}}};
  gltf.json["cameras"] = {
      {{"type", "perspective"},
       {"perspective", {{"yfov", 0.5}, {"aspectRatio", 1.5}, {"znear", 0.1}, {"zfar", 50.0}}}}};
  gltf.add_node({{"name", "thing"}, {"mesh", 0}});
  gltf.add_node({{"name", "eye"}, {"camera", 0}, {"translation", {0.0, 0.0, 3.0}}});
  return gltf;
}

/// Expects `action` to throw an `Error` whose message holds every one of `parts`.
template <typename Error, typename Action>
void expect_error(const Action& action, const std::vector<std::string>& parts) {
  try {
    action();
    ADD_FAILURE() << "no error; expected one with '" << parts.front() << "'";
  } catch (const Error& error) {
    for (const std::string& part : parts) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos)
          << "'" << error.what() << "' lacks '" << part << "'";
    }
  }
}

/// Loads scenes written to a folder of its own.
class GltfLoader : public testing::Test {
 protected:
  Scene load(const TinyGltf& gltf) { return load_scene(gltf.write(folder_ / "scene.glb")); }

  /// Loading fails with a message that names the file and holds every one of `parts`.
  void expect_refused(const TinyGltf& gltf, std::vector<std::string> parts) {
    parts.emplace_back("scene.glb");
    expect_error<InputError>([&] { load(gltf); }, parts);
  }
  void expect_refused_bytes(const std::string& bytes, std::vector<std::string> parts) {
    write_bytes(folder_ / "scene.glb", bytes);
    parts.emplace_back("scene.glb");
    expect_error<InputError>([&] { load_scene(folder_ / "scene.glb"); }, parts);
  }

  TemporaryFolder folder_;
};

}  // namespace occlab::test
