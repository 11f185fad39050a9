// Scenes that are small and claim much, or name what is not theirs: refused by a message, before
// memory is taken.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cstdlib>

#include "renderers/scene/limits.h"
#include "tests/unit/tiny_scenes.h"

namespace occlab {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::tiny_triangle;
using test::TinyGltf;

// Whole PNGs, but for their pixels: their chunks and checksums are right.
std::string png_of_10000_squared() {
  return std::string(
      "\x89\x50\x4e\x47\x0d\x0a\x1a\x0a\x00\x00\x00\x0d\x49\x48\x44\x52\x00\x00\x27\x10"
      "\x00\x00\x27\x10\x08\x02\x00\x00\x00\x35\x2c\xf5\x70\x00\x00\x00\x0c\x49\x44\x41"
      "\x54\x78\x9c\x63\x60\xa0\x0c\x00\x00\x00\x40\x00\x01\xb7\x34\x7c\xef\x00\x00\x00"
      "\x00\x49\x45\x4e\x44\xae\x42\x60\x82",
      69);
}
std::string png_of_8000_squared() {
  return std::string(
      "\x89\x50\x4e\x47\x0d\x0a\x1a\x0a\x00\x00\x00\x0d\x49\x48\x44\x52\x00\x00\x1f\x40"
      "\x00\x00\x1f\x40\x08\x02\x00\x00\x00\x89\x93\x3a\xa3\x00\x00\x00\x0c\x49\x44\x41"
      "\x54\x78\x9c\x63\x60\xa0\x0c\x00\x00\x00\x40\x00\x01\xb7\x34\x7c\xef\x00\x00\x00"
      "\x00\x49\x45\x4e\x44\xae\x42\x60\x82",
      69);
}
std::string png_of_one_pixel() {
  return std::string(
      "\x89\x50\x4e\x47\x0d\x0a\x1a\x0a\x00\x00\x00\x0d\x49\x48\x44\x52\x00\x00\x00\x01"
      "\x00\x00\x00\x01\x08\x02\x00\x00\x00\x90\x77\x53\xde\x00\x00\x00\x0c\x49\x44\x41"
      "\x54\x78\x9c\x63\xf8\xdf\xc0\x00\x00\x04\x01\x01\x80\xc5\x2a\x18\x5d\x00\x00\x00"
      "\x00\x49\x45\x4e\x44\xae\x42\x60\x82",
      69);
}

/// Megabytes of this process at its largest; every test is a process of its own.
double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) / 1024.0;
}

TinyGltf textured(const std::string& image, int textures = 1) {
  TinyGltf gltf = tiny_triangle();
  const int uvs = gltf.add_vec2({{0, 0}, {1, 0}, {0, 1}});
  const int view = gltf.add_view(image);
  gltf.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = uvs;
  const json primitive = gltf.json["meshes"][0]["primitives"][0];
  for (int i = 0; i < textures; ++i) {
    gltf.json["images"].push_back({{"bufferView", view}, {"mimeType", "image/png"}});
    gltf.json["textures"].push_back({{"source", i}});
    gltf.json["materials"][i]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = i;
    gltf.json["meshes"][0]["primitives"][i] = primitive;
    gltf.json["meshes"][0]["primitives"][i]["material"] = i;
  }
  return gltf;
}

class HostileScenes : public test::GltfLoader {
 protected:
  ~HostileScenes() override { set_limits(""); }

  /// Refused with less than `megabytes` on top of what was taken before.
  void expect_cheaply_refused(const TinyGltf& gltf, const std::vector<std::string>& parts,
                              double megabytes) {
    const double before = peak_megabytes();
    expect_refused(gltf, parts);
    EXPECT_LT(peak_megabytes() - before, megabytes);
  }
};

TEST_F(HostileScenes, AHugeTextureIsRefusedBeforeItIsDecoded) {
  expect_cheaply_refused(
      textured(png_of_10000_squared()),
      {"images[0]: 10000x10000: 100000000 pixels; accepted: up to 67108864", "texture_pixels"},
      32.0);
  expect_cheaply_refused(textured(png_of_8000_squared()), {"8000x8000", "image_expansion"}, 32.0);
  set_limits("texture_pixels=100000000");
  expect_cheaply_refused(textured(png_of_10000_squared()), {"image_expansion"}, 32.0);
  set_limits("texture_pixels=100000000,image_expansion=4294967296");
  expect_cheaply_refused(textured(png_of_10000_squared()),
                         {"1200000000 bytes of textures in memory", "texture_bytes"}, 32.0);
}

TEST_F(HostileScenes, TexturesAreCountedTogether) {
  set_limits("texture_bytes=36");
  EXPECT_NO_THROW(load(textured(png_of_one_pixel(), 3)));
  expect_refused(textured(png_of_one_pixel(), 4), {"images[3]", "48 bytes of textures"});
}

TEST_F(HostileScenes, AHundredMillionInstancesAreRefused) {
  TinyGltf gltf = tiny_triangle();
  const json primitive = gltf.json["meshes"][0]["primitives"][0];
  for (int i = 1; i < 10000; ++i) gltf.json["meshes"][0]["primitives"].push_back(primitive);
  for (int i = 1; i < 10000; ++i) gltf.add_node({{"mesh", 0}});
  const double before = peak_megabytes();
  expect_refused(gltf, {"1050000 instances", "accepted: up to 1048576 (limit instances"});
  // A million instances are within the limit and take 68 bytes each.
  EXPECT_LT(peak_megabytes() - before, 250.0);
}

TEST_F(HostileScenes, GeometryIsCountedBeforeItIsRead) {
  TinyGltf gltf = tiny_triangle();
  constexpr std::size_t many = 1 << 20;
  gltf.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] =
      gltf.add_accessor(std::string(many * 12, '\0'), 5126, "VEC3", many);
  gltf.json["meshes"][0]["primitives"][0]["attributes"].erase("NORMAL");
  const json primitive = gltf.json["meshes"][0]["primitives"][0];
  set_limits("vertices=2000000");
  for (int i = 0; i < 5000; ++i) gltf.json["meshes"][0]["primitives"].push_back(primitive);
  expect_cheaply_refused(gltf, {"primitives[1]: 2097152 vertices, with those before"}, 150.0);
  set_limits("triangles=3");
  gltf = tiny_triangle();
  for (int i = 0; i < 3; ++i) gltf.add_node({{"mesh", 0}});
  expect_refused(gltf, {"nodes[4]: 4 triangles in instances"});
}

TEST_F(HostileScenes, NumbersOfThingsHaveLimits) {
  set_limits("cameras=1,lights=2,json_values=200,name_bytes=20");
  EXPECT_NO_THROW(load(tiny_triangle()));
  TinyGltf gltf = tiny_triangle();
  gltf.add_node({{"name", "eye2"}, {"camera", 0}});
  expect_refused(gltf, {"nodes[2]: 2 cameras"});
  gltf = tiny_triangle();
  gltf.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
  for (int i = 0; i < 3; ++i) {
    gltf.add_node({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  }
  expect_refused(gltf, {"lights[0]: 3 lights"});
  gltf = tiny_triangle();
  gltf.json["nodes"][1]["name"] = std::string(21, 'a');
  expect_refused(gltf, {"nodes[1].name: 21 bytes of text"});
  gltf = tiny_triangle();
  gltf.json["extras"] = json(std::vector<int>(200, 1));
  expect_refused(gltf, {"JSON values", "limit json_values"});
  set_limits("file_bytes=500");
  expect_refused(tiny_triangle(), {"bytes; accepted: up to 500 (limit file_bytes"});
}

TEST_F(HostileScenes, BuffersThatAreReadOftenAreCountedEachTime) {
  TinyGltf gltf = tiny_triangle();
  test::write_bytes(folder_ / "data.bin", std::string(1 << 20, '\0'));
  json text = json::parse(R"({"asset": {"version": "2.0"}, "scenes": [{}], "buffers": []})");
  for (int i = 0; i < 100; ++i) {
    text["buffers"].push_back({{"uri", "data.bin"}, {"byteLength", 1 << 20}});
  }
  set_limits("file_bytes=10000000");
  expect_refused_bytes(text.dump(), {"buffers[9].uri", "limit file_bytes"});
}

TEST_F(HostileScenes, DeepJsonIsRefused) {
  const std::string head = R"({"asset": {"version": "2.0"}, "extras": )";
  const auto nested = [&](std::size_t levels) {
    return head + std::string(levels, '[') + std::string(levels, ']') + "}";
  };
  expect_refused_bytes(nested(63), {"no scene"});
  expect_refused_bytes(nested(64), {"65 or more levels of nested JSON"});
  expect_refused_bytes(nested(1'000'000), {"limit nesting"});
  expect_refused_bytes(head + std::string(1'000'000, '['), {"limit nesting"});
}

TEST_F(HostileScenes, TextsArePrintableUtf8) {
  const std::vector<std::string> bad = {"a\nb", "a\x1b[31m", "a\x7f", "a\xc2\x9b",
                                        std::string(1, '\0')};
  for (const std::string& name : bad) {
    TinyGltf gltf = tiny_triangle();
    gltf.json["nodes"][1]["name"] = name;
    expect_refused(gltf, {"nodes[1].name", "control character"});
  }
  TinyGltf gltf = tiny_triangle();
  gltf.json["nodes"][1]["name"] = "\xc2\xa0\xc3\xa9\xe2\x82\xac";
  EXPECT_EQ(load(gltf).cameras.front().name, "\xc2\xa0\xc3\xa9\xe2\x82\xac");
  std::string bytes = tiny_triangle().glb();
  bytes[bytes.find("grey")] = char(0xff);
  expect_refused_bytes(bytes, {"not a valid glTF", "UTF-8"});
}

TEST_F(HostileScenes, NumbersBeyondFloatAreRefused) {
  const auto refused = [&](const char* pointer, const json& value, const std::string& part) {
    TinyGltf gltf = tiny_triangle();
    gltf.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
    gltf.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
    gltf.json[json::json_pointer(pointer)] = value;
    expect_refused(gltf, {part});
  };
  refused("/nodes/1/translation", {1e300, 0, 0}, "nodes[1]: its place or scale");
  refused("/nodes/0/scale", {1e39, 1, 1}, "nodes[0]: its place or scale");
  refused("/nodes/0/scale", {1e-20, 1e-20, 1e-20}, "determinant");
  refused("/cameras/0/perspective/znear", 1e-300, "znear: found 1e-300");
  refused("/cameras/0/perspective/yfov", 1e-300, "yfov");
  refused("/extensions/KHR_lights_punctual/lights/0/intensity", 1e300, "range of float");
  refused("/scenes/0/extras",
          {{"occlab", {{"format", 1}, {"world", {{"probe", "a"}, {"strength", 1e300}}}}}},
          "world.strength: found 1e+300");
  refused("/nodes/0/translation", {1e30, 0, 0}, "size is beyond the range of float");
  refused("/nodes/1/translation", {1e30, 0, 0}, "camera 'eye' is beyond the range of float");
  TinyGltf gltf = tiny_triangle();
  const float huge = 1e38f;
  std::memcpy(&gltf.binary[36], &huge, 4);  // x of normal 0
  expect_refused(gltf, {"normal of vertex 0", "length inf"});
}

class Confinement : public HostileScenes {
 protected:
  Confinement() {
    fs::create_directories(folder_ / "inner/deeper");
    test::write_bytes(folder_ / "secret.bin", std::string(16, 's'));
    test::write_bytes(folder_ / "inner/deeper/own.bin", std::string(16, 'o'));
    fs::create_symlink(folder_ / "secret.bin", folder_ / "inner/link.bin");
    fs::create_directory_symlink(folder_ / "", folder_ / "inner/up");
  }
  ~Confinement() override { unsetenv("OCCLAB_ALLOW_OUTSIDE"); }

  /// The message of a file in inner/ whose buffer is at `uri`; that it has no scene if it was read.
  std::string error_of(const std::string& uri) {
    const json text = {{"asset", {{"version", "2.0"}}},
                       {"buffers", {{{"uri", uri}, {"byteLength", 16}}}}};
    test::write_bytes(folder_ / "inner/a.gltf", text.dump());
    try {
      load_scene(folder_ / "inner/a.gltf");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  void expect_outside(const std::string& uri) {
    EXPECT_NE(error_of(uri).find("a.gltf: buffers[0].uri: '"), std::string::npos) << error_of(uri);
    EXPECT_NE(error_of(uri).find("lies outside the folder"), std::string::npos) << error_of(uri);
  }
  void expect_read(const std::string& uri) {
    EXPECT_NE(error_of(uri).find("has no scene"), std::string::npos) << error_of(uri);
  }
};

TEST_F(Confinement, UrisStayInTheFolderOfTheirFile) {
  for (const char* uri : {"deeper/own.bin", "./deeper/own.bin", "deeper/../deeper/own.bin",
                          "../inner/deeper/own.bin", "deeper%2fown.bin"}) {
    expect_read(uri);
  }
  for (const char* uri : {"../secret.bin", "deeper/../../secret.bin", "%2e%2e/secret.bin",
                          "..%2fsecret.bin", "link.bin", "up/secret.bin", "../inner2/none.bin"}) {
    expect_outside(uri);
  }
  for (const std::string& uri :
       {(folder_ / "secret.bin").string(), std::string("file:///etc/hostname"),
        std::string("http://example.org/a.bin"), std::string("deeper/own.bin%00.png")}) {
    EXPECT_NE(error_of(uri).find("accepted: a base64 data URI or a relative path"),
              std::string::npos)
        << error_of(uri);
  }
}

TEST_F(Confinement, FoldersCanBeAllowed) {
  setenv("OCCLAB_ALLOW_OUTSIDE", ("/nowhere:" + (folder_ / "inner").string()).c_str(), 1);
  expect_outside("../secret.bin");
  setenv("OCCLAB_ALLOW_OUTSIDE", ("/nowhere:" + (folder_ / "").string()).c_str(), 1);
  expect_read("../secret.bin");
  expect_read("link.bin");
  setenv("OCCLAB_ALLOW_OUTSIDE", "/", 1);
  expect_read("../secret.bin");
}

TEST_F(Confinement, WhatIsNoFileIsNotOpened) {
  ASSERT_EQ(mkfifo((folder_ / "inner/pipe.bin").c_str(), 0600), 0);
  EXPECT_NE(error_of("pipe.bin").find("no regular file"),
            std::string::npos);  // and does not wait
  EXPECT_NE(error_of("deeper").find("it is a folder"), std::string::npos);
}

}  // namespace
}  // namespace occlab
