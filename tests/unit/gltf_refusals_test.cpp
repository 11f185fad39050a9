// Every kind of broken or unusable glTF file: one InputError that names the file and the place.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <limits>

#include "tests/unit/tiny_scenes.h"

namespace occlab {
namespace {

using nlohmann::json;
using GltfRefusals = test::GltfLoader;
using test::tiny_triangle;
using test::TinyGltf;

TEST_F(GltfRefusals, RefusesWhatIsNoGltf) {
  test::expect_error<InputError>([&] { load_scene(folder_ / "none.glb"); },
                                 {"none.glb", "no such"});
  test::expect_error<InputError>([&] { load_scene(std::filesystem::temp_directory_path()); },
                                 {"folder"});
  expect_refused_bytes("", {"not a valid glTF"});
  expect_refused_bytes("glTF", {"4 bytes"});
  expect_refused_bytes(std::string(5000, '\0'), {"not a valid glTF"});
  expect_refused_bytes("[1, 2]", {"not an object"});
  expect_refused_bytes("{}", {"asset", "missing"});
  expect_refused_bytes(R"({"asset": {"version": "1.0"}})", {"asset.version", "1.0", "2.x"});
  expect_refused_bytes(R"({"asset": {"version": "2.0"}})", {"no scene"});
  expect_refused_bytes(R"({"asset": {"version": "2.0"}, "nodes": 1e999})", {"not a valid glTF"});
}

TEST_F(GltfRefusals, RefusesEveryTruncationAndSurvivesEveryDamagedByte) {
  const std::string good = tiny_triangle().glb();
  // Every length would take seconds; a prime step meets every alignment.
  for (std::size_t length = 0; length < good.size(); length += 7) {
    expect_refused_bytes(good.substr(0, length), {"scene.glb"});
  }
  // A damaged byte may still be a valid scene; the answer must be that or an InputError, no more.
  std::size_t refused = 0;
  constexpr std::array<unsigned, 3> flips = {0x01, 0x80, 0xff};
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string bytes = good;
    bytes[i] = char(static_cast<unsigned char>(bytes[i]) ^ flips[i % 3]);
    test::write_bytes(folder_ / "scene.glb", bytes);
    try {
      load_scene(folder_ / "scene.glb");
    } catch (const InputError& error) {
      ++refused;
      EXPECT_NE(std::string(error.what()).find("scene.glb"), std::string::npos);
    }
  }
  EXPECT_GT(refused, good.size() / 2);
}

TEST_F(GltfRefusals, RefusesScenesWithoutCameraOrTriangles) {
  TinyGltf gltf = tiny_triangle();
  gltf.json["nodes"][1].erase("camera");
  expect_refused(gltf, {"no camera"});
  gltf = tiny_triangle();
  gltf.json["nodes"][0].erase("mesh");
  expect_refused(gltf, {"no triangles"});
  gltf = tiny_triangle();
  gltf.json["meshes"][0]["primitives"][0]["mode"] = 1;
  expect_refused(gltf, {"no triangles"});
  gltf.json["meshes"][0]["primitives"][0]["mode"] = 5;
  expect_refused(gltf, {"mode", "found 5", "accepted: 4"});
}

TEST_F(GltfRefusals, RefusesBadCameras) {
  TinyGltf gltf = tiny_triangle();
  gltf.json["cameras"][0] = {
      {"type", "orthographic"},
      {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0.1}, {"zfar", 9}}}};
  expect_refused(gltf, {"'eye'", "orthographic", "accepted: perspective"});
  for (const auto& [key, value] : std::vector<std::pair<std::string, double>>{
           {"yfov", 0.0}, {"yfov", 3.2}, {"znear", -0.1}, {"aspectRatio", 0.0}, {"zfar", 0.05}}) {
    gltf = tiny_triangle();
    gltf.json["cameras"][0]["perspective"][key] = value;
    expect_refused(gltf, {"cameras[0].perspective", key});
  }
  gltf = tiny_triangle();
  gltf.add_node({{"name", "eye"}, {"camera", 0}});
  expect_refused(gltf, {"two cameras", "'eye'"});
  gltf = tiny_triangle();
  gltf.json["nodes"][1]["scale"] = {1, 1, -1};
  expect_refused(gltf, {"mirrored"});
}

TEST_F(GltfRefusals, RefusesNonFiniteVertices) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float value : {nan, infinity}) {
    TinyGltf gltf = tiny_triangle();
    std::memcpy(&gltf.binary[12], &value, 4);  // x of vertex 1
    expect_refused(gltf, {"1 of 3 positions", "'triangle'", "vertex 1"});
    gltf = tiny_triangle();
    std::memcpy(&gltf.binary[36], &value, 4);  // x of normal 0
    expect_refused(gltf, {"1 of 3 normals", "'triangle'", "vertex 0"});
  }
  TinyGltf gltf = tiny_triangle();
  std::memset(&gltf.binary[36], 0, 12);
  expect_refused(gltf, {"normal of vertex 0", "length 0"});
}

TEST_F(GltfRefusals, RefusesEveryIndexOutOfRange) {
  const auto refused = [&](const char* pointer, const json& value, const std::string& part) {
    TinyGltf gltf = tiny_triangle();
    gltf.json[json::json_pointer(pointer)] = value;
    expect_refused(gltf, {part});
  };
  refused("/scene", 1, "scene: found 1");
  refused("/scenes/0/nodes/0", 9, "scenes[0].nodes[0]: found 9");
  refused("/nodes/0/mesh", 1, "nodes[0].mesh: found 1");
  refused("/nodes/0/mesh", -1, "accepted: an integer of at least 0");
  refused("/nodes/0/mesh", "x", "accepted: an integer of at least 0");
  refused("/nodes/1/camera", 1, "nodes[1].camera: found 1");
  refused("/meshes/0/primitives/0/indices", 3, "indices: found 3");
  refused("/meshes/0/primitives/0/material", 1, "material: found 1");
  refused("/meshes/0/primitives/0/attributes/POSITION", 3, "POSITION: found 3");
  refused("/accessors/0/bufferView", 3, "accessors[0].bufferView: found 3");
  refused("/bufferViews/0/buffer", 1, "bufferViews[0].buffer: found 1");

  refused("/bufferViews/0/byteOffset", 100, "bufferViews[0]: bytes 100 to 136");
  refused("/bufferViews/2/byteLength", 1000, "bufferViews[2]: bytes");
  refused("/bufferViews/0/byteOffset", 0xfffffffffffffff0u, "bufferViews[0]: bytes");
  refused("/bufferViews/0/byteStride", 4, "byteStride 4; accepted: 12");
  refused("/bufferViews/0/byteStride", 16, "accessors[0]: 3 elements of 12 bytes, 16 apart");
  refused("/accessors/0/byteOffset", 4, "accessors[0]: 3 elements");
  refused("/accessors/0/byteOffset", 0xfffffffffffffffcu, "accessors[0]: 3 elements");
  refused("/accessors/0/count", 4, "accessors[0]: 4 elements");
  refused("/accessors/0/count", 40000000, "accessors[0]: 40000000 elements");
  refused("/accessors/0/count", 4000000000u, "4000000000 vertices");
  refused("/accessors/0/count", 0, "count 0");
  refused("/accessors/1/count", 2, "2 elements for 3 vertices");
  refused("/accessors/2/count", 2, "no whole number of triangles");
  refused("/accessors/0/componentType", 5130, "componentType 5130");
  refused("/accessors/2/componentType", 5126, "componentType 5126; accepted for indices");
  refused("/accessors/0/type", "VEC2", "has 2 components");
  refused("/accessors/0/type", "MAT4", "type 'MAT4'");

  TinyGltf gltf = tiny_triangle();
  gltf.binary[72 + 2] = 3;  // index 1 becomes 3
  expect_refused(gltf, {"index 1 of mesh 'triangle' is 3", "3 vertices"});

  gltf = tiny_triangle();
  const int view = gltf.add_view(test::bytes_of(std::vector<std::uint32_t>{7}));
  gltf.json["accessors"][0]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", view}, {"componentType", 5125}}},
      {"values", {{"bufferView", 0}}}};
  expect_refused(gltf, {"sparse.indices", "index 0 is 7"});
  gltf = tiny_triangle();
  gltf.json["accessors"][0].erase("bufferView");
  expect_refused(gltf, {"accessors[0]", "neither"});
}

TEST_F(GltfRefusals, RefusesBadNodeGraphs) {
  TinyGltf gltf = tiny_triangle();
  gltf.json["nodes"][0]["children"] = {2};
  gltf.json["nodes"].push_back({{"children", {0}}});
  expect_refused(gltf, {"nodes[2].children[0]", "node 0"});
  gltf = tiny_triangle();
  gltf.json["nodes"][0]["children"] = {0};
  expect_refused(gltf, {"nodes[0].children[0]", "node 0"});
  gltf = tiny_triangle();
  gltf.json["nodes"][0]["children"] = {1};  // also a root
  expect_refused(gltf, {"node 1", "two parents"});
  gltf = tiny_triangle();
  gltf.json["nodes"][0]["scale"] = {1, 0, 1};
  expect_refused(gltf, {"nodes[0]", "determinant"});
  gltf = tiny_triangle();
  gltf.json["nodes"][0]["rotation"] = {0, 0, 0, 0};
  expect_refused(gltf, {"nodes[0].rotation", "unit"});
  gltf = tiny_triangle();
  gltf.json["nodes"][0]["translation"] = {0, 0};
  expect_refused(gltf, {"nodes[0].translation", "found 2 elements", "3 numbers"});
}

TEST_F(GltfRefusals, RefusesRequiredExtensionsItDoesNotKnow) {
  TinyGltf gltf = tiny_triangle();
  gltf.json["extensionsRequired"] = {"KHR_lights_punctual", "KHR_draco_mesh_compression"};
  expect_refused(gltf, {"extensionsRequired[1]", "KHR_draco_mesh_compression",
                        "accepted: KHR_lights_punctual, KHR_materials_ior"});
  gltf.json["extensionsRequired"] = {"KHR_lights_punctual"};
  EXPECT_NO_THROW(load(gltf));
}

}  // namespace
}  // namespace occlab
