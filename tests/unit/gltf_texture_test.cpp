// Base colour textures and alpha masks of glTF files: formats, samplers, errors.
#include <gtest/gtest.h>

#include <cmath>

#include "renderers/scene/limits.h"
#include "renderers/shared/surface_texture.h"
#include "tests/unit/tiny_images.h"
#include "tests/unit/tiny_scenes.h"

namespace occlab {
namespace {

using nlohmann::json;
using test::tiny_png;
using test::tiny_triangle;
using test::TinyGltf;

/// IEC 61966-2-1, of a value above its linear part.
double linear(double srgb) { return std::pow((srgb + 0.055) / 1.055, 2.4); }

class GltfTextures : public test::GltfLoader {
 protected:
  /// The triangle with `png` as its texture.
  static TinyGltf textured(const std::string& png) {
    TinyGltf gltf = tiny_triangle();
    const int uvs = gltf.add_vec2({{0, 0}, {1, 0}, {0, 1}});
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = uvs;
    gltf.json["images"] = {{{"bufferView", gltf.add_view(png)}, {"mimeType", "image/png"}}};
    gltf.json["textures"] = {{{"source", 0}}};
    gltf.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    return gltf;
  }
  Image texture_of(const std::string& png) { return load(textured(png)).textures.at(0); }
};

const std::string one_grey = tiny_png(1, 1, 8, 0, "\x80");

TEST_F(GltfTextures, OddFormatsAreReadAsTheyAreMeant) {
  const Image grey = texture_of(tiny_png(2, 1, 8, 0, std::string("\x80\x40", 2)));
  ASSERT_EQ(grey.channels(), 3);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(grey.at(0, 0, c), linear(128.0 / 255.0), 1e-6);
    EXPECT_NEAR(grey.at(1, 0, c), linear(64.0 / 255.0), 1e-6);
  }
  // 8 bits would make both 128.
  const Image deep = texture_of(tiny_png(2, 1, 16, 0, std::string("\x80\x10\x80\xf0", 4)));
  EXPECT_NEAR(deep.at(0, 0), linear(32784.0 / 65535.0), 1e-6);
  EXPECT_NEAR(deep.at(1, 0), linear(33008.0 / 65535.0), 1e-6);

  const Image both = texture_of(tiny_png(1, 2, 8, 4, std::string("\x80\x40\xff\x00", 4)));
  ASSERT_EQ(both.channels(), 4);
  EXPECT_NEAR(both.at(0, 0, 2), linear(128.0 / 255.0), 1e-6) << "alpha darkens no colour";
  EXPECT_NEAR(both.at(0, 0, 3), 64.0 / 255.0, 1e-6) << "alpha is linear";
  EXPECT_EQ(both.at(0, 1, 0), 1.0f);
  EXPECT_EQ(both.at(0, 1, 3), 0.0f);
  const Image rgba = texture_of(tiny_png(1, 1, 8, 6, std::string("\xff\x80\x40\x20", 4)));
  ASSERT_EQ(rgba.channels(), 4);
  EXPECT_NEAR(rgba.at(0, 0, 2), linear(64.0 / 255.0), 1e-6);
  EXPECT_NEAR(rgba.at(0, 0, 3), 32.0 / 255.0, 1e-6);
}

TEST_F(GltfTextures, SamplersSayWhatLiesBeyondTheEdges) {
  TinyGltf gltf = textured(one_grey);
  const auto sampling = [&] { return load(gltf).materials.at(0).sampling; };
  EXPECT_EQ(sampling().wrap_u, wrap_repeat);
  EXPECT_FALSE(sampling().nearest);
  gltf.json["textures"][0]["sampler"] = 0;
  gltf.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}};
  EXPECT_EQ(sampling().wrap_u, wrap_clamp_to_edge);
  EXPECT_EQ(sampling().wrap_v, wrap_mirrored_repeat);
  EXPECT_TRUE(sampling().nearest);
  gltf.json["samplers"] = {{{"wrapT", 10497}, {"magFilter", 9729}, {"minFilter", 9987}}};
  EXPECT_EQ(sampling().wrap_v, wrap_repeat);
  EXPECT_FALSE(sampling().nearest);
  EXPECT_TRUE(load(gltf).warnings.empty());

  gltf.json["samplers"] = {{{"wrapS", 33069}}};
  expect_refused(gltf, {"samplers[0].wrapS", "33069", "10497 (repeat)"});
  gltf.json["samplers"] = {{{"magFilter", 9987}}};
  expect_refused(gltf, {"samplers[0].magFilter", "9987", "9728 (nearest)"});
  gltf.json["textures"][0]["sampler"] = 1;
  expect_refused(gltf, {"textures[0].sampler", "found 1"});
}

TEST_F(GltfTextures, MasksHaveACutoff) {
  TinyGltf gltf = textured(one_grey);
  json& material = gltf.json["materials"][0];
  material["pbrMetallicRoughness"]["baseColorFactor"] = {1.0, 1.0, 1.0, 0.25};
  EXPECT_FALSE(load(gltf).materials[0].alpha_cutoff.has_value());
  material["alphaMode"] = "MASK";
  EXPECT_EQ(load(gltf).materials[0].alpha_cutoff, 0.5f);  // the specification's default
  EXPECT_EQ(load(gltf).materials[0].alpha, 0.25f);
  EXPECT_TRUE(load(gltf).warnings.empty());
  material["alphaCutoff"] = 0.75;
  material["doubleSided"] = false;  // makes no difference: all surfaces are
  EXPECT_EQ(load(gltf).materials[0].alpha_cutoff, 0.75f);
  material["alphaCutoff"] = -0.5;
  expect_refused(gltf, {"materials[0].alphaCutoff", "-0.5", "at least 0"});
  material["alphaCutoff"] = "half";
  expect_refused(gltf, {"materials[0].alphaCutoff", "accepted: a number"});
}

TEST_F(GltfTextures, MissingImagesAreErrors) {
  TinyGltf gltf = textured(one_grey);
  gltf.json["images"][0] = {{"uri", "bark%20brown.png"}};
  expect_refused(gltf, {"images[0].uri", "bark brown.png"});
  test::write_bytes(folder_ / "bark brown.png", one_grey);
  EXPECT_EQ(load(gltf).textures.size(), 1u);
  test::write_bytes(folder_ / "bark brown.png", "GIF89a");
  expect_refused(gltf, {"images[0]", "PNG or JPEG"});
  test::write_bytes(folder_ / "bark brown.png", one_grey.substr(0, 20));
  expect_refused(gltf, {"images[0]"});
  gltf.json["images"][0] = {{"uri", "../bark.png"}};
  expect_refused(gltf, {"images[0].uri", "lies outside the folder"});
  gltf.json["images"][0] = json::object();
  expect_refused(gltf, {"images[0]", "bufferView", "missing"});
  gltf.json["textures"][0] = {{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}};
  expect_refused(gltf, {"textures[0]", "'grey'", "has no source"});
  gltf.json["textures"][0] = {{"source", 7}};
  expect_refused(gltf, {"textures[0].source", "found 7"});
}

TEST_F(GltfTextures, AlphaCountsTowardsTheLimit) {
  const TinyGltf gltf = textured(tiny_png(1, 1, 8, 6, "RGBA"));
  set_limits("texture_bytes=16");
  EXPECT_NO_THROW(load(gltf));
  set_limits("texture_bytes=15");
  expect_refused(gltf, {"images[0]", "16 bytes of textures in memory", "texture_bytes"});
  set_limits("");
}

}  // namespace
}  // namespace occlab
