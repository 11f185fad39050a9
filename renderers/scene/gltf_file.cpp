#include "renderers/scene/gltf_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "renderers/scene/confined_path.h"
#include "renderers/scene/error.h"
#include "renderers/scene/limited_json.h"
#include "renderers/scene/limits.h"

namespace occlab {
namespace fs = std::filesystem;
using nlohmann::json;

std::optional<JsonValue> JsonValue::find(const char* key) const {
  if (!value_->is_object()) wrong_type("an object");
  const auto member = value_->find(key);
  if (member == value_->end()) return std::nullopt;
  return JsonValue(*file_, *member, place_.empty() ? key : place_ + "." + key);
}

JsonValue JsonValue::at(const char* key) const {
  if (auto member = find(key)) return *member;
  fail(fmt::format("the key '{}' is missing", key));
}

JsonValue JsonValue::element(std::size_t i) const {
  if (i >= array_size())
    fail(fmt::format("has {} elements; at least {} are needed", array_size(), i + 1));
  return {*file_, (*value_)[i], fmt::format("{}[{}]", place_, i)};
}

std::size_t JsonValue::array_size() const {
  if (!value_->is_array()) wrong_type("an array");
  return value_->size();
}

std::vector<std::string> JsonValue::keys() const {
  if (!value_->is_object()) wrong_type("an object");
  std::vector<std::string> keys;
  for (const auto& member : value_->items()) keys.push_back(member.key());
  return keys;
}

const std::string& JsonValue::raw_text() const {
  if (!value_->is_string()) wrong_type("a text");
  return value_->get_ref<const std::string&>();
}

// Names end up in messages, on terminals and in reports: what would move a cursor or end a line
// there is no part of them. The parser has made sure of UTF-8.
std::string JsonValue::text() const {
  const std::string& text = raw_text();
  require_within(Limit::name_bytes, text.size(), "bytes of text", where());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    // U+0080 to U+009F are C2 80 to C2 9F.
    const bool second_half = byte == 0xc2 && static_cast<unsigned char>(text[i + 1]) < 0xa0;
    if (byte < 0x20 || byte == 0x7f || second_half) {
      fail(fmt::format("the text has a control character at byte {}; accepted: printable text", i));
    }
  }
  return text;
}

double JsonValue::number() const {
  if (!value_->is_number() || !std::isfinite(value_->get<double>())) wrong_type("a number");
  return value_->get<double>();
}

float JsonValue::real() const {
  const double value = number();
  if (!(std::abs(value) <= double(std::numeric_limits<float>::max()))) {
    fail(fmt::format("found {:g}; accepted: a number within the range of float", value));
  }
  return float(value);
}

bool JsonValue::boolean() const {
  if (!value_->is_boolean()) wrong_type("true or false");
  return value_->get<bool>();
}

std::uint64_t JsonValue::unsigned_integer() const {
  if (value_->is_number_unsigned()) return value_->get<std::uint64_t>();
  // Some exporters write 3.0 where the specification has an integer.
  if (value_->is_number_float()) {
    const double value = value_->get<double>();
    if (value >= 0.0 && value < 0x1p53 && value == std::floor(value)) return std::uint64_t(value);
  }
  wrong_type("an integer of at least 0");
}

std::size_t JsonValue::index(std::size_t count, std::string_view what) const {
  const std::uint64_t value = unsigned_integer();
  if (value >= count) {
    fail(
        fmt::format("found {}; accepted: an index below {}, the number of {}", value, count, what));
  }
  return value;
}

std::vector<double> JsonValue::numbers(std::size_t count) const {
  if (array_size() != count) {
    fail(fmt::format("found {} elements; accepted: {} numbers", array_size(), count));
  }
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i) numbers.push_back(element(i).number());
  return numbers;
}

double JsonValue::number_or(const char* key, double fallback) const {
  const auto member = find(key);
  return member ? member->number() : fallback;
}

float JsonValue::real_or(const char* key, float fallback) const {
  const auto member = find(key);
  return member ? member->real() : fallback;
}

std::uint64_t JsonValue::unsigned_or(const char* key, std::uint64_t fallback) const {
  const auto member = find(key);
  return member ? member->unsigned_integer() : fallback;
}

std::string JsonValue::text_or(const char* key, const std::string& fallback) const {
  const auto member = find(key);
  return member ? member->text() : fallback;
}

std::vector<JsonValue> JsonValue::array(const char* key) const {
  std::vector<JsonValue> elements;
  if (const auto member = find(key)) {
    const std::size_t count = member->array_size();
    elements.reserve(count);
    for (std::size_t i = 0; i < count; ++i) elements.push_back(member->element(i));
  }
  return elements;
}

void JsonValue::require_keys(const std::vector<std::string>& accepted) const {
  for (const std::string& key : keys()) {
    if (std::ranges::find(accepted, key) == accepted.end()) {
      fail(fmt::format("unknown key '{}'{}", key, accepted_words(key, accepted)));
    }
  }
}

std::string JsonValue::where() const {
  return place_.empty() ? file_->string() : fmt::format("{}: {}", file_->string(), place_);
}

void JsonValue::fail(const std::string& message) const {
  throw InputError(fmt::format("{}: {}", where(), message));
}

void JsonValue::wrong_type(std::string_view accepted) const {
  std::string found = value_->dump(-1, ' ', false, json::error_handler_t::replace);
  if (found.size() > 60) found = found.substr(0, 57) + "...";
  fail(fmt::format("found {}; accepted: {}", found, accepted));
}

namespace {

/// `bytes_read` is what was read before, and then also this.
std::vector<std::byte> read_file(const fs::path& path, std::uint64_t& bytes_read) {
  std::error_code error;
  // Before it is opened: opening a pipe waits for somebody to write into it.
  if (!fs::is_regular_file(path, error)) {
    throw InputError(fmt::format("{}: cannot be read: {}", path.string(),
                                 fs::is_directory(path, error) ? "it is a folder"
                                 : fs::exists(path, error)     ? "it is no regular file"
                                                               : "no such file"));
  }
  std::ifstream stream(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = stream ? std::streamoff(stream.tellg()) : -1;
  if (size < 0) throw InputError(fmt::format("{}: cannot be read", path.string()));
  bytes_read = saturating_add(bytes_read, std::uint64_t(size));
  require_within(Limit::file_bytes, bytes_read, "bytes", path.string());
  std::vector<std::byte> bytes(static_cast<std::size_t>(size));
  stream.seekg(0);
  stream.read(reinterpret_cast<char*>(bytes.data()), size);
  if (stream.gcount() != size) {
    throw InputError(fmt::format("{}: cannot be read to its end", path.string()));
  }
  return bytes;
}

std::uint32_t little_endian_u32(std::span<const std::byte> bytes, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::uint32_t(bytes[offset + i]) << (8 * i);
  return value;
}

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

std::vector<std::byte> decode_base64(const JsonValue& uri, std::string_view text) {
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  std::vector<std::byte> bytes;
  bytes.reserve(text.size() * 3 / 4);
  std::uint32_t pending = 0;
  int pending_bits = 0;
  for (const char c : text) {
    const int digit = base64_digit(c);
    if (digit < 0) uri.fail("the data URI is not valid base64");
    pending = (pending << 6) | std::uint32_t(digit);
    pending_bits += 6;
    if (pending_bits >= 8) {
      pending_bits -= 8;
      bytes.push_back(std::byte((pending >> pending_bits) & 0xffu));
    }
  }
  return bytes;
}

std::string decode_percent(const JsonValue& uri, std::string_view text) {
  const auto hex = [&](char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    uri.fail("the URI holds a '%' without two hexadecimal digits");
  };
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    if (i + 2 >= text.size()) uri.fail("the URI ends within a '%' sequence");
    decoded += char(hex(text[i + 1]) * 16 + hex(text[i + 2]));
    i += 2;
  }
  return decoded;
}

}  // namespace

GltfFile::GltfFile(const fs::path& path) : path_(path), file_bytes_(read_file(path, bytes_read_)) {
  read_container();
  const auto asset = root().at("asset");
  const std::string version = asset.at("version").text();
  if (!version.starts_with("2.")) {
    asset.at("version").fail(fmt::format("found '{}'; accepted: glTF 2.x", version));
  }
  for (const char* key : {"accessors", "bufferViews", "buffers", "cameras", "images", "materials",
                          "meshes", "nodes", "samplers", "scenes", "textures"}) {
    lists_[key] = root().array(key);
  }
  load_buffers();
}

void GltfFile::read_container() {
  const auto fail = [&](const std::string& reason) {
    throw InputError(fmt::format("{}: not a valid glTF file: {}", path_.string(), reason));
  };
  const std::span<const std::byte> bytes = file_bytes_;
  std::span<const std::byte> text = bytes;
  if (bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0) {
    // Binary container: glTF 2.0 specification, section 4.4.
    if (bytes.size() < 20) fail(fmt::format("{} bytes; a .glb has at least 20", bytes.size()));
    const std::uint32_t version = little_endian_u32(bytes, 4);
    if (version != 2) fail(fmt::format("container version {}; accepted: 2", version));
    const std::uint32_t length = little_endian_u32(bytes, 8);
    if (length != bytes.size()) {
      fail(fmt::format("its header says {} bytes and the file has {}: truncated?", length,
                       bytes.size()));
    }
    constexpr std::uint32_t json_type = 0x4e4f534a;
    constexpr std::uint32_t binary_type = 0x004e4942;
    std::size_t offset = 12;
    for (std::size_t chunk = 0; offset < bytes.size(); ++chunk) {
      if (bytes.size() - offset < 8) fail(fmt::format("chunk {} has no header", chunk));
      const std::size_t size = little_endian_u32(bytes, offset);
      const std::uint32_t type = little_endian_u32(bytes, offset + 4);
      offset += 8;
      if (size > bytes.size() - offset) {
        fail(fmt::format("chunk {} of {} bytes passes the end of the file", chunk, size));
      }
      if (chunk == 0 && type != json_type) fail("the first chunk is not JSON");
      if (chunk == 0) text = bytes.subspan(offset, size);
      if (chunk == 1 && type == binary_type) binary_chunk_ = bytes.subspan(offset, size);
      offset += size;
    }
  }
  json_ = parse_limited_json({reinterpret_cast<const char*>(text.data()), text.size()},
                             path_.string() + ": not a valid glTF file");
  if (!json_.is_object()) fail("the JSON is not an object");
}

void GltfFile::load_buffers() {
  const auto& buffers = list("buffers");
  loaded_buffers_.reserve(buffers.size());
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    const std::uint64_t length = buffers[i].at("byteLength").unsigned_integer();
    std::span<const std::byte> bytes;
    if (const auto uri = buffers[i].find("uri")) {
      bytes = loaded_buffers_.emplace_back(read_uri(*uri));
    } else if (i == 0 && !binary_chunk_.empty()) {
      bytes = binary_chunk_;
    } else {
      buffers[i].fail("has neither a uri nor the file's binary chunk");
    }
    if (length > bytes.size()) {
      buffers[i].fail(
          fmt::format("byteLength {} but only {} bytes are there", length, bytes.size()));
    }
    buffers_.push_back(bytes.first(length));
  }
}

std::vector<std::byte> GltfFile::read_uri(const JsonValue& uri) const {
  const std::string& text = uri.raw_text();
  if (text.starts_with("data:")) {
    bytes_read_ = saturating_add(bytes_read_, text.size());
    require_within(Limit::file_bytes, bytes_read_, "bytes", uri.where());
    const std::size_t comma = text.find(',');
    if (comma == std::string::npos || !std::string_view(text).substr(0, comma).ends_with(";base64"))
      uri.fail("accepted: a base64 data URI or a relative path");
    return decode_base64(uri, std::string_view(text).substr(comma + 1));
  }
  const std::string name = decode_percent(uri, uri.text());
  const fs::path relative = name;
  if (relative.is_absolute() || text.find("://") != std::string::npos ||
      name.find('\0') != std::string::npos) {
    uri.fail(fmt::format("found '{}'; accepted: a base64 data URI or a relative path", text));
  }
  const fs::path file = confined_path(path_.parent_path(), relative, uri.where());
  try {
    return read_file(file, bytes_read_);
  } catch (const InputError& error) {
    uri.fail(error.what());
  }
}

}  // namespace occlab
