// Image files that are small and claim much, in the formats' own words.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "renderers/scene/environment.h"
#include "renderers/scene/image_io.h"
#include "tests/unit/tiny_scenes.h"

namespace occlab {
namespace {

std::string u32(std::uint32_t value) { return test::bytes_of(std::vector<std::uint32_t>{value}); }

std::string attribute(const std::string& name, const std::string& type, const std::string& value) {
  return name + '\0' + type + '\0' + u32(std::uint32_t(value.size())) + value;
}

std::string exr(const std::string& attributes, std::uint32_t version = 2) {
  return "\x76\x2f\x31\x01" + u32(version) + attributes;
}

std::string window(std::uint32_t x_max, std::uint32_t y_max) {
  return attribute("dataWindow", "box2i", u32(0) + u32(0) + u32(x_max) + u32(y_max));
}

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) / 1024.0;
}

class HostileImages : public testing::Test {
 protected:
  ~HostileImages() override { set_limits(""); }

  void expect_refused(const std::string& bytes, const std::string& part) {
    test::write_bytes(folder_ / "a.exr", bytes);
    const double before = peak_megabytes();
    test::expect_error<InputError>([&] { read_exr(folder_ / "a.exr"); }, {"a.exr", part});
    test::expect_error<InputError>(
        [&] { load_environment({.source = (folder_ / "a.exr").string()}); }, {"a.exr"});
    EXPECT_LT(peak_megabytes() - before, 32.0);
  }

  TemporaryFolder folder_;
};

TEST_F(HostileImages, ExrAttributesLieWithinTheFile) {
  const std::string name = std::string("a") + '\0' + "string" + '\0';
  expect_refused(exr(name + u32(2'000'000'000) + "x"), "says 2000000000 bytes; the file has 1");
  expect_refused(exr(name + u32(0xffffffff) + "x"), "says 4294967295 bytes");
  expect_refused(exr(name + "ab"), "ends too early");
  expect_refused(exr(""), "ends too early");
  expect_refused("\x76\x2f\x31\x01", "ends too early");
  expect_refused(exr(std::string(300, 'a')), "name in its header is too long");
}

TEST_F(HostileImages, ExrAttributesHaveTheSizesOfTheirTypes) {
  // OpenEXR would read on where the value ends, not where the file says that it does.
  expect_refused(exr(attribute("compression", "compression", "1234567")), "a compression has 1");
  expect_refused(exr(attribute("a", "v2f", "1234")), "a v2f has 8");
  const std::string channel = std::string("R") + '\0' + std::string(16, '\0');
  expect_refused(exr(attribute("channels", "chlist", channel + '\0' + "rest")), "a chlist has 19");
  expect_refused(exr(attribute("channels", "chlist", channel)), "ends too early");
  expect_refused(exr(attribute("preview", "preview", u32(60000) + u32(60000))), "ends too early");
  expect_refused(exr(attribute("a", "stringvector", u32(2'000'000'000))), "ends too early");
  expect_refused(exr(attribute("a", "stringvector", u32(1) + "a" + u32(9) + "b")),
                 "ends too early");
}

TEST_F(HostileImages, ExrSizesAreJudgedBeforeOpenExrSeesThem) {
  expect_refused(exr(window(0x7ffffffe, 0x7ffffffe)), "pixels; accepted: up to 268435456");
  expect_refused(exr(window(20000, 20000)), "limit image_pixels");
  expect_refused(exr(window(0xfffffff0, 5)), "data window is -15x6");
  expect_refused(exr(window(15, 7) + attribute("tiles", "tiledesc",
                                               u32(0x10000) + u32(0x10000) + std::string(1, '\0'))),
                 "tiles have 4294967296 pixels");
  expect_refused(exr("", 2 | 0x800), "deep");
  // In the second header of a multi-part file.
  const std::string first = attribute("name", "string", "a") + window(1, 1) + std::string(1, '\0');
  expect_refused(exr(first + window(20000, 20000), 2 | 0x1000), "limit image_pixels");
}

TEST_F(HostileImages, RadianceSizes) {
  const auto hdr = [](const std::string& size) {
    return "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + size + "\n" + std::string(32, '\x80');
  };
  expect_refused(hdr("-Y 16000 +X 16000"), "16000x16000");
  expect_refused(hdr("-Y 2000000000 +X 2000000000"), "a.exr");
  expect_refused(hdr("-Y -5 +X 10"), "a.exr");
  expect_refused(hdr("-Y 0 +X 0"), "a.exr");
  expect_refused(hdr("nothing"), "a.exr");
}

TEST_F(HostileImages, LimitsOfChannelsAndMemory) {
  Layers layers;
  layers.add("a", Image(8, 4, 20, 0.5f));
  write_exr(folder_ / "whole.exr", layers, {});
  EXPECT_NO_THROW(read_exr(folder_ / "whole.exr"));
  const auto refused = [&](const char* limits, const std::string& part) {
    set_limits(limits);
    test::expect_error<InputError>([&] { read_exr(folder_ / "whole.exr"); }, {"8x4", part});
  };
  refused("image_channels=19", "20 channels");
  refused("image_bytes=2559", "2560 bytes in memory");
}

TEST_F(HostileImages, OnlyThreeFormatsAreTried) {
  // OpenImageIO would try each of its readers.
  expect_refused("GIF89a" + std::string(64, '\0'), "accepted are OpenEXR, Radiance HDR and PNG");
  expect_refused("P6 1 1 255\nabc", "accepted are OpenEXR, Radiance HDR and PNG");
  std::filesystem::remove(folder_ / "a.exr");
  ASSERT_EQ(mkfifo((folder_ / "a.exr").c_str(), 0600), 0);
  test::expect_error<InputError>([&] { read_exr(folder_ / "a.exr"); }, {"no regular file"});
}

}  // namespace
}  // namespace occlab
