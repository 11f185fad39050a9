#include "renderers/scene/image_headers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <optional>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr std::uint32_t multipart_flag = 0x1000;
constexpr std::uint32_t deep_flag = 0x800;
constexpr std::size_t longest_exr_name = 255;
constexpr std::uint64_t most_tile_pixels = 1u << 24;

/// Goes through a source; every step past its end fails.
class Cursor {
 public:
  Cursor(const ByteSource& file, const std::string& where) : file_(&file), where_(&where) {}

  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(fmt::format("{}: not a readable image: {}", *where_, reason));
  }
  std::uint64_t rest() const { return file_->size - offset_; }
  void skip(std::uint64_t bytes) {
    if (bytes > rest()) fail("it ends too early");
    offset_ += bytes;
  }
  template <std::size_t Size>
  std::array<std::byte, Size> take() {
    std::array<std::byte, Size> bytes{};
    const std::uint64_t start = offset_;
    skip(Size);
    if (!file_->read(start, bytes)) fail("it cannot be read");
    return bytes;
  }
  std::uint32_t little_endian() {
    const auto b = take<4>();
    return std::uint32_t(b[0]) | std::uint32_t(b[1]) << 8 | std::uint32_t(b[2]) << 16 |
           std::uint32_t(b[3]) << 24;
  }
  std::uint32_t big_endian() {
    const auto b = take<4>();
    return std::uint32_t(b[3]) | std::uint32_t(b[2]) << 8 | std::uint32_t(b[1]) << 16 |
           std::uint32_t(b[0]) << 24;
  }
  /// A text that ends with a zero.
  std::string text() {
    std::string text;
    for (;;) {
      const auto c = std::to_integer<char>(take<1>()[0]);
      if (c == '\0') return text;
      if (text.size() == longest_exr_name) fail("a name in its header is too long");
      text += c;
    }
  }

 private:
  const ByteSource* file_;
  const std::string* where_;
  std::uint64_t offset_ = 0;
};

/// A window's pixels; both corners belong to it.
std::uint64_t window_pixels(Cursor cursor) {
  std::array<std::int64_t, 4> corner{};
  for (std::int64_t& value : corner) value = std::int32_t(cursor.little_endian());
  const std::int64_t width = corner[2] - corner[0] + 1;
  const std::int64_t height = corner[3] - corner[1] + 1;
  if (width <= 0 || height <= 0)
    cursor.fail(fmt::format("its data window is {}x{}", width, height));
  return saturating_multiply(std::uint64_t(width), std::uint64_t(height));
}

std::uint64_t tile_pixels(Cursor cursor) {
  const std::uint64_t width = cursor.little_endian();
  return saturating_multiply(width, cursor.little_endian());
}

/// The sizes of attributes that OpenEXR reads without looking at the size that the file states.
/// From there on it would take pixels for attributes.
std::optional<std::uint64_t> fixed_size(const std::string& type) {
  static const std::map<std::string, std::uint64_t> sizes = {
      {"box2f", 16},      {"box2i", 16},  {"chromaticities", 32},
      {"compression", 1}, {"double", 8},  {"envmap", 1},
      {"float", 4},       {"int", 4},     {"keycode", 28},
      {"lineOrder", 1},   {"m33d", 72},   {"m33f", 36},
      {"m44d", 128},      {"m44f", 64},   {"rational", 8},
      {"tiledesc", 9},    {"v2d", 16},    {"v2f", 8},
      {"v2i", 8},         {"v3d", 24},    {"v3f", 12},
      {"v3i", 12},        {"timecode", 8}};
  const auto found = sizes.find(type);
  return found == sizes.end() ? std::nullopt : std::optional(found->second);
}

/// The bytes that OpenEXR will read for a value of this type.
std::uint64_t size_read(Cursor cursor, const std::string& type, std::uint64_t stated) {
  if (const auto fixed = fixed_size(type)) return *fixed;
  const std::uint64_t before = cursor.rest();
  if (type == "chlist") {
    while (!cursor.text().empty()) cursor.skip(16);
  } else if (type == "preview") {
    const std::uint64_t pixels = cursor.little_endian();
    cursor.skip(saturating_multiply(saturating_multiply(pixels, cursor.little_endian()), 4));
  } else if (type == "stringvector") {
    while (before - cursor.rest() < stated) cursor.skip(cursor.little_endian());
  } else if (type == "idmanifest") {
    cursor.fail("ID manifests are not accepted");
  } else {
    return stated;
  }
  return before - cursor.rest();
}

/// One attribute after its name.
void check_attribute(Cursor& cursor, const std::string& name, Limit most_pixels,
                     const std::string& where) {
  const std::string type = cursor.text();
  const std::uint64_t size = cursor.little_endian();
  if (size > cursor.rest()) {
    cursor.fail(fmt::format("the attribute '{}' of its header says {} bytes; the file has {} more",
                            name, size, cursor.rest()));
  }
  if (size_read(cursor, type, size) != size) {
    cursor.fail(fmt::format("the attribute '{}' of its header says {} bytes; a {} has {}", name,
                            size, type, size_read(cursor, type, size)));
  }
  if (name == "dataWindow") {
    require_within(most_pixels, window_pixels(cursor), "pixels", where);
  }
  if (name == "tiles" && tile_pixels(cursor) > most_tile_pixels) {
    cursor.fail(fmt::format("its tiles have {} pixels; accepted: up to {}", tile_pixels(cursor),
                            most_tile_pixels));
  }
  cursor.skip(size);
}

}  // namespace

ByteSource bytes_in_memory(std::span<const std::byte> bytes) {
  return {bytes.size(), [bytes](std::uint64_t offset, std::span<std::byte> target) {
            std::memcpy(target.data(), bytes.data() + offset, target.size());
            return true;
          }};
}

void check_exr_header(const ByteSource& file, Limit most_pixels, const std::string& where) {
  Cursor cursor(file, where);
  cursor.skip(4);  // the magic number
  const std::uint32_t version = cursor.little_endian();
  if (version & deep_flag) cursor.fail("deep images are not accepted");
  // A header ends with an empty name, and the list of a multi-part file's headers with another.
  for (bool more = true; more; more = (version & multipart_flag) != 0) {
    std::string name = cursor.text();
    if (name.empty()) return;
    for (; !name.empty(); name = cursor.text()) {
      check_attribute(cursor, name, most_pixels, where);
    }
  }
}

void check_png_chunks(const ByteSource& file, const std::string& where) {
  Cursor cursor(file, where);
  cursor.skip(8);  // the signature
  std::array<std::byte, 4> type{};
  const auto is = [&](const char* name) { return std::memcmp(type.data(), name, 4) == 0; };
  for (bool first = true; !is("IEND"); first = false) {
    const std::uint64_t size = cursor.big_endian();
    type = cursor.take<4>();
    if (first && !is("IHDR")) cursor.fail("its first chunk is not IHDR");
    cursor.skip(size + 4);  // and the checksum
  }
}

}  // namespace occlab
