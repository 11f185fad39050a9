#include "renderers/scene/image_io.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "renderers/scene/error.h"
#include "tests/unit/tiny_scenes.h"

namespace occlab {
namespace {

Image counting_image(int width, int height, int channels, float start) {
  Image image(width, height, channels);
  float value = start;
  for (float& v : image.values()) v = value += 0.37f;
  return image;
}

TEST(ImageIo, ExrKeepsLayersValuesAndMetadata) {
  TemporaryFolder folder;
  Layers layers;
  layers.add("radiance", counting_image(5, 3, 3, -2.0f));
  layers.add("ambient_occlusion", counting_image(5, 3, 1, 0.0f));
  layers.add("position", counting_image(5, 3, 4, 100.0f));
  layers.add("sh_visibility", counting_image(5, 3, 16, 1e-8f));
  const Metadata metadata = {{"occlab:method", "s3ho"}, {"occlab:note", "two words, \"quoted\""}};
  write_exr(folder / "a.exr", layers, metadata);
  const ExrFile file = read_exr(folder / "a.exr");
  EXPECT_EQ(file.metadata, metadata);
  ASSERT_EQ(file.layers.all().size(), layers.all().size());
  for (const auto& layer : layers.all()) {
    const Image* found = file.layers.find(layer.name);
    ASSERT_NE(found, nullptr) << layer.name;
    EXPECT_EQ(*found, layer.image) << layer.name;  // bit for bit
  }
  test::expect_error<InputError>([&] { file.layers.at("radiances"); },
                                 {"radiances", "did you mean 'radiance'"});
}

TEST(ImageIo, ExrKeepsNanAndInfinity) {
  TemporaryFolder folder;
  Image image(2, 1, 1);
  image.at(0, 0) = std::numeric_limits<float>::quiet_NaN();
  image.at(1, 0) = -std::numeric_limits<float>::infinity();
  Layers layers;
  layers.add("x", image);
  write_exr(folder / "a.exr", layers, {});
  const ExrFile file = read_exr(folder / "a.exr");
  EXPECT_TRUE(std::isnan(file.layers.at("x").at(0, 0)));
  EXPECT_EQ(file.layers.at("x").at(1, 0), -std::numeric_limits<float>::infinity());
}

TEST(ImageIo, ReadRgbTakesOneAndThreeChannels) {
  TemporaryFolder folder;
  Layers grey;
  grey.add("", counting_image(4, 2, 1, 0.0f));
  write_exr(folder / "grey.exr", grey, {});
  const Image repeated = read_rgb(folder / "grey.exr");
  EXPECT_EQ(repeated.channels(), 3);
  EXPECT_EQ(repeated.at(3, 1, 2), grey.at("").at(3, 1));
  Layers colour;
  colour.add("", counting_image(4, 2, 3, 0.0f));
  write_exr(folder / "colour.exr", colour, {});
  EXPECT_EQ(read_rgb(folder / "colour.exr"), colour.at(""));
}

TEST(ImageIo, RefusesBadFilesByName) {
  TemporaryFolder folder;
  const auto refused = [&](const std::string& name, const std::string& part) {
    test::expect_error<InputError>([&] { read_rgb(folder / name); }, {name, part});
    test::expect_error<InputError>([&] { read_exr(folder / name); }, {name, part});
  };
  refused("missing.exr", "no such file");
  test::write_bytes(folder / "empty.exr", "");
  refused("empty.exr", "not a readable image");
  test::write_bytes(folder / "text.exr", "this is no image");
  refused("text.exr", "not a readable image");

  Layers layers;
  layers.add("", counting_image(64, 64, 3, 0.0f));
  write_exr(folder / "whole.exr", layers, {});
  const std::string whole = test::read_bytes(folder / "whole.exr");
  for (const std::size_t length : {whole.size() / 8, whole.size() / 2, whole.size() - 1}) {
    test::write_bytes(folder / "cut.exr", whole.substr(0, length));
    refused("cut.exr", "image");
  }
}

TEST(ImageIo, WritesCompletelyOrNotAtAll) {
  TemporaryFolder folder;
  Layers layers;
  layers.add("", counting_image(4, 4, 3, 0.0f));
  const auto path = folder / "no/such/folder/a.exr";
  test::expect_error<DeviceError>([&] { write_exr(path, layers, {}); }, {"a.exr"});
  test::expect_error<DeviceError>([&] { write_png(folder / "none/a.png", layers.at("")); },
                                  {"a.png"});
  write_exr(folder / "a.exr", layers, {});
  write_exr(folder / "a.exr", layers, {});  // replaces
  write_png(folder / "a.png", layers.at(""));
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "")) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"a.exr", "a.png"}));
}

TEST(ImageIo, PngRoundsAndClamps) {
  TemporaryFolder folder;
  Image image(4, 1, 1);
  image.at(0, 0) = -1.0f;
  image.at(1, 0) = 0.5f;
  image.at(2, 0) = 1.0f;
  image.at(3, 0) = 7.0f;
  write_png(folder / "a.png", image);
  const Image back = read_rgb(folder / "a.png");
  EXPECT_EQ(back.at(0, 0), 0.0f);
  EXPECT_FLOAT_EQ(back.at(1, 0), 128.0f / 255.0f);
  EXPECT_EQ(back.at(2, 0), 1.0f);
  EXPECT_EQ(back.at(3, 0), 1.0f);
}

}  // namespace
}  // namespace occlab
