#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace occlab {

/// A JSON value together with its file and its place in it ("nodes[3].rotation"), so that every
/// error can name them. Everything throws InputError where the value is not what is asked for.
class JsonValue {
 public:
  JsonValue(const std::filesystem::path& file, const nlohmann::json& value, std::string place)
      : file_(&file), value_(&value), place_(std::move(place)) {}

  /// A member of this object; nothing if it is absent.
  std::optional<JsonValue> find(const char* key) const;
  /// A member of this object that must be there.
  JsonValue at(const char* key) const;
  /// An element of this array.
  JsonValue element(std::size_t i) const;
  /// The number of elements of this array.
  std::size_t array_size() const;
  /// The keys of this object.
  std::vector<std::string> keys() const;
  /// Throws InputError for a key of this object that is not accepted.
  void require_keys(const std::vector<std::string>& accepted) const;

  /// Printable text of at most Limit::name_bytes.
  std::string text() const;
  /// Any text, of any length.
  const std::string& raw_text() const;
  double number() const;  ///< finite
  float real() const;     ///< a number within the range of float
  bool boolean() const;
  std::uint64_t unsigned_integer() const;
  /// An index below `count` of the things called `what`.
  std::size_t index(std::size_t count, std::string_view what) const;
  /// An array of exactly `count` finite numbers.
  std::vector<double> numbers(std::size_t count) const;

  double number_or(const char* key, double fallback) const;
  float real_or(const char* key, float fallback) const;
  std::uint64_t unsigned_or(const char* key, std::uint64_t fallback) const;
  std::string text_or(const char* key, const std::string& fallback) const;
  /// The array called `key`, as values; none if it is absent.
  std::vector<JsonValue> array(const char* key) const;

  const std::filesystem::path& file() const { return *file_; }
  /// "FILE: PLACE", as messages begin.
  std::string where() const;
  /// Throws InputError "FILE: PLACE: message".
  [[noreturn]] void fail(const std::string& message) const;

 private:
  [[noreturn]] void wrong_type(std::string_view accepted) const;

  const std::filesystem::path* file_;
  const nlohmann::json* value_;
  std::string place_;
};

/// A .glb or .gltf: its JSON and its buffers. Reads the container itself, because tinygltf 2.7
/// skips keys of a wrong type and trusts some lengths; a laboratory must do neither.
class GltfFile {
 public:
  explicit GltfFile(const std::filesystem::path& path);
  GltfFile(const GltfFile&) = delete;
  GltfFile& operator=(const GltfFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  JsonValue root() const { return {path_, json_, ""}; }
  /// The elements of a top-level array such as "nodes"; none if the file has no such array.
  const std::vector<JsonValue>& list(std::string_view key) const {
    return lists_.find(key)->second;
  }

  /// An accessor's elements as floats, `components` each; normalised integers are converted as the
  /// glTF 2.0 specification, section 3.6.2.2 says. Sparse accessors are resolved.
  std::vector<float> read_floats(std::size_t accessor, int components) const;
  /// An accessor of unsigned scalars.
  std::vector<std::uint32_t> read_indices(std::size_t accessor) const;
  /// The bytes of a buffer view.
  std::span<const std::byte> view_bytes(std::size_t buffer_view) const;
  /// The bytes that a URI stands for: a data URI, or a file in this one's folder or below it
  /// (confined_path.h). All that are read count towards Limit::file_bytes.
  std::vector<std::byte> read_uri(const JsonValue& uri) const;
  /// The number of an accessor's elements, as it says itself: at least 1.
  std::uint64_t element_count(std::size_t accessor) const;

 private:
  void read_container();
  void load_buffers();

  std::filesystem::path path_;
  mutable std::uint64_t bytes_read_ = 0;  // of this file and those it names
  nlohmann::json json_;
  std::vector<std::byte> file_bytes_;
  std::span<const std::byte> binary_chunk_;
  std::vector<std::vector<std::byte>> loaded_buffers_;
  std::vector<std::span<const std::byte>> buffers_;
  std::map<std::string, std::vector<JsonValue>, std::less<>> lists_;
};

}  // namespace occlab
