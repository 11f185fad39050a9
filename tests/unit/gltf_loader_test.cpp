#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

#include "renderers/scene/data_root.h"
#include "renderers/scene/error.h"
#include "renderers/scene/image_io.h"
#include "renderers/scene/scene.h"
#include "tests/unit/tiny_scenes.h"

namespace occlab {
namespace {

using nlohmann::json;
using test::GltfLoader;
using test::tiny_triangle;
using test::TinyGltf;

void expect_near(glm::vec3 found, glm::vec3 expected, float tolerance) {
  EXPECT_LE(glm::length(found - expected), tolerance)
      << "found " << found.x << " " << found.y << " " << found.z << ", expected " << expected.x
      << " " << expected.y << " " << expected.z;
}

void expect_warning(const Scene& scene, const std::string& part) {
  const auto has_part = [&](const std::string& w) { return w.find(part) != std::string::npos; };
  EXPECT_TRUE(std::ranges::any_of(scene.warnings, has_part)) << part;
}

TEST_F(GltfLoader, ReadsGeometryMaterialAndCamera) {
  const Scene scene = load(tiny_triangle());
  EXPECT_EQ(scene.name, "scene");
  EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
  ASSERT_EQ(scene.meshes.size(), 1u);
  const Mesh& mesh = scene.meshes[0];
  EXPECT_EQ(mesh.name, "triangle");
  EXPECT_EQ(mesh.positions, (std::vector<glm::vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  EXPECT_EQ(mesh.normals, std::vector<glm::vec3>(3, {0, 0, 1}));
  EXPECT_EQ(mesh.indices, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_TRUE(mesh.uvs.empty());
  EXPECT_EQ(scene.triangle_count(), 1u);
  EXPECT_EQ(scene.materials.at(0).name, "grey");
  EXPECT_EQ(scene.materials.at(0).albedo, glm::vec3(0.25f, 0.5f, 0.75f));
  EXPECT_EQ(scene.bounds_min, glm::vec3(0, 0, 0));
  EXPECT_EQ(scene.bounds_max, glm::vec3(1, 1, 0));

  const Camera& camera = find_camera(scene, "eye");
  EXPECT_EQ(&camera, &find_camera(scene, ""));
  EXPECT_EQ(camera.yfov, 0.5f);
  EXPECT_EQ(camera.aspect, 1.5f);
  EXPECT_EQ(camera.znear, 0.1f);
  EXPECT_EQ(camera.zfar, 50.0f);
  EXPECT_EQ(glm::vec3(camera.world_from_camera[3]), glm::vec3(0, 0, 3));
  test::expect_error<InputError>([&] { find_camera(scene, "eyes"); },
                                 {"scene.glb", "eyes", "did you mean 'eye'"});
}

TEST_F(GltfLoader, ComposesTheHierarchyAndSharesMeshes) {
  TinyGltf gltf = tiny_triangle();
  const float h = std::sqrt(0.5f);
  // Parent: translation (10,0,0), a quarter turn about +Y, scale 2; children move and mirror.
  gltf.json["nodes"].push_back({{"mesh", 0}, {"translation", {1.0, 2.0, 0.0}}});
  gltf.json["nodes"].push_back(
      {{"mesh", 0}, {"matrix", {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1}}});
  gltf.add_node({{"translation", {10.0, 0.0, 0.0}},
                 {"rotation", {0.0, h, 0.0, h}},
                 {"scale", {2.0, 2.0, 2.0}},
                 {"children", {2, 3}}});
  const Scene scene = load(gltf);
  ASSERT_EQ(scene.instances.size(), 3u);
  EXPECT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.triangle_count(), 3u);
  const auto place = [&](std::size_t i, glm::vec3 p) {
    return glm::vec3(scene.instances[i].world_from_object * glm::vec4(p, 1.0f));
  };
  // R_y(90 degrees) takes +X to -Z and +Z to +X.
  expect_near(place(1, {0, 0, 0}), {10, 4, -2}, 1e-5f);
  expect_near(place(1, {1, 0, 0}), {10, 4, -4}, 1e-5f);
  expect_near(place(2, {1, 0, 0}), {10 + 14, 12, -8}, 1e-5f);
  expect_near(scene.bounds_min, {0, 0, -10}, 1e-5f);
  expect_near(scene.bounds_max, {24, 14, 0}, 1e-5f);
}

TEST_F(GltfLoader, EveryPrimitiveBecomesAMesh) {
  TinyGltf gltf = tiny_triangle();
  json second = gltf.json["meshes"][0]["primitives"][0];
  second.erase("indices");
  second.erase("material");
  gltf.json["meshes"][0]["primitives"].push_back(second);
  const Scene scene = load(gltf);
  EXPECT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.instances.size(), 2u);
  EXPECT_EQ(scene.meshes[1].indices, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(scene.materials[std::size_t(scene.meshes[1].material)].albedo, glm::vec3(0.8f));
  expect_warning(scene, "without a material");
}

TEST_F(GltfLoader, MakesFlatNormalsAndSaysSo) {
  TinyGltf gltf = tiny_triangle();
  // Two triangles that share an edge and fold by 90 degrees; welded, without normals.
  const int positions = gltf.add_vec3({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  const int indices = gltf.add_indices({0, 1, 2, 0, 2, 3});
  gltf.json["meshes"][0]["primitives"][0] = {
      {"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"material", 0}};
  const Scene scene = load(gltf);
  const Mesh& mesh = scene.meshes[0];
  ASSERT_EQ(mesh.normals.size(), 6u);
  ASSERT_EQ(mesh.positions.size(), 6u);
  EXPECT_EQ(mesh.normals[1], glm::vec3(0, 0, 1));
  EXPECT_EQ(mesh.normals[4], glm::vec3(1, 0, 0));
  EXPECT_EQ(mesh.positions[5], glm::vec3(0, 0, 1));
  expect_warning(scene, "flat");
}

TEST_F(GltfLoader, ReadsStridedQuantisedAndSparseAccessors) {
  TinyGltf gltf = tiny_triangle();
  gltf.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  // Positions: normalised 16-bit integers, 8 bytes apart; -32768 clamps to -1.
  const int view = gltf.add_view(
      test::bytes_of(std::vector<std::int16_t>{32767, 0, 0, 99, -32768, 0, 0, 99, 0, -32767, 0}));
  gltf.json["bufferViews"][view]["byteStride"] = 8;
  // The sparse part moves vertex 2 to z = 1.
  const int sparse_indices = gltf.add_view(test::bytes_of(std::vector<std::uint8_t>{2}));
  const int sparse_values = gltf.add_view(test::bytes_of(std::vector<std::int16_t>{0, 0, 32767}));
  gltf.json["accessors"].push_back(
      {{"bufferView", view},
       {"componentType", 5122},
       {"normalized", true},
       {"type", "VEC3"},
       {"count", 3},
       {"sparse",
        {{"count", 1},
         {"indices", {{"bufferView", sparse_indices}, {"componentType", 5121}}},
         {"values", {{"bufferView", sparse_values}}}}}});
  gltf.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] =
      gltf.json["accessors"].size() - 1;
  const Scene scene = load(gltf);
  EXPECT_EQ(scene.meshes[0].positions, (std::vector<glm::vec3>{{1, 0, 0}, {-1, 0, 0}, {0, 0, 1}}));
}

TEST_F(GltfLoader, ReadsTextGltfWithDataUriAndWithAnExternalBuffer) {
  TinyGltf gltf = tiny_triangle();
  const std::string binary = gltf.binary;
  json text = gltf.json;
  text["buffers"] = {{{"byteLength", binary.size()}, {"uri", "my%20data.bin"}}};
  test::write_bytes(folder_ / "a.gltf", text.dump());
  test::expect_error<InputError>([&] { load_scene(folder_ / "a.gltf"); },
                                 {"a.gltf", "buffers[0].uri", "my data.bin"});
  test::write_bytes(folder_ / "my data.bin", binary);
  EXPECT_EQ(load_scene(folder_ / "a.gltf").meshes[0].positions[1], glm::vec3(1, 0, 0));

  // "Man" is "TWFu" (RFC 4648); the buffer is only referenced, its bytes are never drawn.
  text["buffers"].push_back(
      {{"byteLength", 3}, {"uri", "data:application/octet-stream;base64,TWFu"}});
  test::write_bytes(folder_ / "b.gltf", text.dump());
  EXPECT_NO_THROW(load_scene(folder_ / "b.gltf"));
  text["buffers"][1]["byteLength"] = 4;
  test::write_bytes(folder_ / "b.gltf", text.dump());
  test::expect_error<InputError>([&] { load_scene(folder_ / "b.gltf"); },
                                 {"b.gltf", "buffers[1]", "only 3 bytes"});
  text["buffers"][1] = {{"byteLength", 3}, {"uri", "data:;base64,TW*u"}};
  test::write_bytes(folder_ / "b.gltf", text.dump());
  test::expect_error<InputError>([&] { load_scene(folder_ / "b.gltf"); }, {"b.gltf", "base64"});
}

TEST_F(GltfLoader, ReadsLightsThroughTheirNodes) {
  TinyGltf gltf = tiny_triangle();
  gltf.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"color", {1.0, 0.5, 0.25}}, {"intensity", 8.0}},
      {{"type", "directional"}, {"intensity", 3.0}},
      {{"type", "spot"}, {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}}};
  const float h = std::sqrt(0.5f);
  const auto light = [&](const char* name, int index, json extra) {
    extra["name"] = name;
    extra["extensions"]["KHR_lights_punctual"]["light"] = index;
    gltf.add_node(extra);
  };
  light("lamp", 0, {{"translation", {1, 2, 3}}, {"scale", {4, 4, 4}}});
  light("sun", 1, {{"rotation", {-h, 0.0, 0.0, h}}});  // turns -Z to -Y
  light("spot", 2, {{"rotation", {0.0, h, 0.0, h}}});  // turns -Z to -X
  const Scene scene = load(gltf);
  ASSERT_EQ(scene.lights.size(), 3u);
  EXPECT_EQ(scene.lights[0].name, "lamp");
  EXPECT_EQ(scene.lights[0].type, LightType::point);
  EXPECT_EQ(scene.lights[0].position_world, glm::vec3(1, 2, 3));
  EXPECT_EQ(scene.lights[0].intensity, glm::vec3(8, 4, 2));
  EXPECT_EQ(scene.lights[1].type, LightType::directional);
  expect_near(scene.lights[1].direction_world, {0, -1, 0}, 1e-6f);
  EXPECT_EQ(scene.lights[1].intensity, glm::vec3(3));
  EXPECT_EQ(scene.lights[2].type, LightType::spot);
  expect_near(scene.lights[2].direction_world, {-1, 0, 0}, 1e-6f);
  EXPECT_EQ(scene.lights[2].inner_cone_angle, 0.25f);
  EXPECT_EQ(scene.lights[2].outer_cone_angle, 0.5f);

  TinyGltf bad = gltf;
  bad.json["extensions"]["KHR_lights_punctual"]["lights"][0]["type"] = "area";
  expect_refused(bad, {"area", "point, directional, spot"});
  bad = gltf;
  bad.json["nodes"][2]["extensions"]["KHR_lights_punctual"]["light"] = 3;
  expect_refused(bad, {"nodes[2]", "found 3", "lights"});
  bad = gltf;
  bad.json["extensions"]["KHR_lights_punctual"]["lights"][1]["intensity"] = -1.0;
  expect_refused(bad, {"negative"});
}

TEST_F(GltfLoader, DecodesBaseColourTexturesToLinear) {
  TinyGltf gltf = tiny_triangle();
  Image srgb(2, 1, 3);
  srgb.at(0, 0, 0) = 1.0f;
  srgb.at(1, 0, 1) = 128.0f / 255.0f;
  write_png(folder_ / "colour.png", srgb);
  const int view = gltf.add_view(test::read_bytes(folder_ / "colour.png"));
  gltf.json["images"] = {{{"bufferView", view}, {"mimeType", "image/png"}}};
  gltf.json["textures"] = {{{"source", 0}}};
  auto& material = gltf.json["materials"][0];
  material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  expect_refused(gltf, {"TEXCOORD_0", "missing"});

  const int uvs = gltf.add_vec2({{0, 0}, {1, 0}, {0, 1}});
  gltf.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = uvs;
  const Scene scene = load(gltf);
  ASSERT_EQ(scene.textures.size(), 1u);
  EXPECT_EQ(scene.materials[0].albedo_texture, 0);
  const Image& image = scene.textures[0];
  ASSERT_EQ(image.width(), 2);
  EXPECT_FLOAT_EQ(image.at(0, 0, 0), 1.0f);
  EXPECT_FLOAT_EQ(image.at(0, 0, 1), 0.0f);
  EXPECT_NEAR(image.at(1, 0, 1), 0.2158605f, 1e-6f);  // IEC 61966-2-1 of 128/255
  EXPECT_EQ(scene.meshes[0].uvs, (std::vector<glm::vec2>{{0, 0}, {1, 0}, {0, 1}}));

  // The extension's own example: the image's lower left quadrant, turned.
  material["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] = {
      {"offset", {0, 1}}, {"rotation", std::numbers::pi / 2.0}, {"scale", {0.5, 0.5}}};
  const std::vector<glm::vec2> turned = load(gltf).meshes[0].uvs;
  const std::vector<glm::vec2> expected = {{0, 1}, {0, 0.5}, {0.5, 1}};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(turned[i].x, expected[i].x, 1e-6f);
    EXPECT_NEAR(turned[i].y, expected[i].y, 1e-6f);
  }

  // Damaged, not cut short: there OpenImageIO 2.4 leaks its own message across libpng's longjmp.
  gltf.binary[gltf.json["bufferViews"][view]["byteOffset"].get<std::size_t>() + 18] ^= 0x55;
  expect_refused(gltf, {"images[0]", "damaged"});
  gltf.json["images"][0] = {{"uri", "data:image/webp;base64,TWFu"}};
  expect_refused(gltf, {"images[0]", "PNG or JPEG"});
}

TEST_F(GltfLoader, TexturesThatNobodyUsesAreNotRead) {
  TinyGltf gltf = tiny_triangle();
  gltf.json["images"] = {{{"uri", "missing.png"}}};
  gltf.json["textures"] = {{{"source", 0}}};
  gltf.json["materials"].push_back(
      {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
  EXPECT_TRUE(load(gltf).textures.empty());
}

TEST_F(GltfLoader, WarnsOfWhatItDoesNotUse) {
  TinyGltf gltf = tiny_triangle();
  auto& material = gltf.json["materials"][0];
  material["pbrMetallicRoughness"].erase("metallicFactor");  // the default is 1
  material["alphaMode"] = "BLEND";
  material["emissiveFactor"] = {0.0, 1.0, 0.0};
  const Scene scene = load(gltf);
  expect_warning(scene, "'grey': metallic 1");
  expect_warning(scene, "'grey': alphaMode BLEND");
  expect_warning(scene, "'grey': emission");
  material["alphaMode"] = "SHINY";
  expect_refused(gltf, {"materials[0].alphaMode", "SHINY", "OPAQUE, MASK, BLEND"});
}

TEST_F(GltfLoader, ReadsTheExtrasStrictly) {
  TinyGltf gltf = tiny_triangle();
  EXPECT_FALSE(load(gltf).environment.has_value());
  json& extras = gltf.json["scenes"][0]["extras"];
  extras["of_somebody_else"] = 1;
  extras["occlab"] = {
      {"format", 1},
      {"resolution", {640, 360}},
      {"lights", json::object()},
      {"warnings", {"lamp: radius lost"}},
      {"world", {{"probe", "cathedral"}, {"rotation_degrees", -30.0}, {"strength", 2.0}}}};
  const Scene scene = load(gltf);
  ASSERT_TRUE(scene.environment.has_value());
  EXPECT_EQ(scene.environment->probe, "cathedral");
  EXPECT_EQ(scene.environment->rotation_degrees, -30.0f);
  EXPECT_EQ(scene.environment->strength, 2.0f);
  expect_warning(scene, "export: lamp: radius lost");

  const json good = extras;
  const auto refused_with = [&](const char* key, const json& value, const std::string& part) {
    extras = good;
    extras["occlab"]["world"][key] = value;
    expect_refused(gltf, {"scenes[0].extras.occlab.world", part});
  };
  refused_with("probe", 3, "accepted: a text");
  refused_with("probe", "", "empty");
  refused_with("rotation_degrees", "a lot", "accepted: a number");
  refused_with("strength", -1.0, "negative");
  refused_with("rotation", 30.0, "unknown key 'rotation'");
  extras = good;
  extras["occlab"]["format"] = 2;
  expect_refused(gltf, {"format", "found 2", "accepted: 1"});
}

TEST_F(GltfLoader, DropsTheScaleOfACameraAndClosesAnInfiniteProjection) {
  TinyGltf gltf = tiny_triangle();
  gltf.json["nodes"][1]["scale"] = {2, 3, 4};
  gltf.json["cameras"][0]["perspective"].erase("zfar");
  const Scene scene = load(gltf);
  expect_near(glm::vec3(scene.cameras[0].world_from_camera[1]), {0, 1, 0}, 1e-6f);
  // The farthest corner of the bounds is at distance sqrt(1 + 1 + 9).
  EXPECT_GE(scene.cameras[0].zfar, std::sqrt(11.0f));
  EXPECT_LE(scene.cameras[0].zfar, 1.02f * std::sqrt(11.0f));
  expect_warning(scene, "zfar");
}

TEST_F(GltfLoader, ReadsVeryDeepHierarchies) {
  TinyGltf gltf = tiny_triangle();
  constexpr int depth = 100000;
  for (int i = 0; i < depth; ++i) {
    gltf.json["nodes"].push_back({{"children", {i + 3}}});
  }
  gltf.json["nodes"].push_back({{"mesh", 0}});
  gltf.json["scenes"][0]["nodes"].push_back(2);
  EXPECT_EQ(load(gltf).instances.size(), 2u);
}

TEST_F(GltfLoader, LoadsHalfAMillionTrianglesQuickly) {
  constexpr int side = 500;  // 2 * 500 * 500 triangles
  std::vector<glm::vec3> positions;
  std::vector<std::uint32_t> indices;
  for (int y = 0; y <= side; ++y) {
    for (int x = 0; x <= side; ++x) positions.emplace_back(x, y, 0);
  }
  for (std::uint32_t y = 0; y < side; ++y) {
    for (std::uint32_t x = 0; x < side; ++x) {
      const std::uint32_t a = y * (side + 1) + x;
      for (const std::uint32_t i : {a, a + 1, a + side + 1, a + 1, a + side + 2, a + side + 1}) {
        indices.push_back(i);
      }
    }
  }
  TinyGltf gltf = tiny_triangle();
  auto& primitive = gltf.json["meshes"][0]["primitives"][0];
  primitive["attributes"]["POSITION"] = gltf.add_vec3(positions);
  primitive["attributes"]["NORMAL"] =
      gltf.add_vec3(std::vector<glm::vec3>(positions.size(), {0, 0, 1}));
  primitive["indices"] = gltf.add_accessor(test::bytes_of(indices), 5125, "SCALAR", indices.size());
  const auto path = gltf.write(folder_ / "big.glb");
  const auto start = std::chrono::steady_clock::now();
  const Scene scene = load_scene(path);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  EXPECT_EQ(scene.triangle_count(), 500000u);
  EXPECT_EQ(scene.bounds_max, glm::vec3(side, side, 0));
  EXPECT_LT(seconds.count(), 1.5);
  RecordProperty("milliseconds", int(1000.0 * seconds.count()));
}

TEST(DataRoot, FindsScenesByNameAndByPath) {
  TemporaryFolder folder;
  std::filesystem::create_directories(folder / "scenes/room");
  std::filesystem::create_directories(folder / "scenes/unfinished");
  test::write_bytes(folder / "scenes/room/room.glb", "");
  setenv("OCCLAB_DATA", (folder / "").c_str(), 1);
  EXPECT_EQ(scene_names(), std::vector<std::string>{"room"});
  EXPECT_EQ(scene_path("room"), folder / "scenes/room/room.glb");
  EXPECT_EQ(scene_path("room.glb"), "room.glb");
  EXPECT_EQ(scene_path("other/room"), "other/room");
  test::expect_error<InputError>([] { scene_path("rom"); },
                                 {"unknown scene 'rom'", "did you mean 'room'", "accepted: room"});
  unsetenv("OCCLAB_DATA");
  EXPECT_EQ(data_root(), std::filesystem::path(OCCLAB_SOURCE_DIR));
}

}  // namespace
}  // namespace occlab
