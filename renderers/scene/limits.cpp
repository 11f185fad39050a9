#include "renderers/scene/limits.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cstdlib>
#include <limits>
#include <vector>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr std::uint64_t one = 1;

constexpr auto declared = std::to_array<LimitInfo>({
    {Limit::file_bytes, "file_bytes", one << 31,
     "bytes of a scene with its buffers and textures, or of any other file that is read whole"},
    {Limit::config_bytes, "config_bytes", one << 24, "bytes of an experiment file"},
    {Limit::nesting, "nesting", 64, "levels of nesting in JSON and TOML"},
    {Limit::json_values, "json_values", one << 24, "values in a JSON text"},
    {Limit::name_bytes, "name_bytes", 1024, "bytes of a name or other text in a scene"},
    {Limit::instances, "instances", one << 20, "primitives that a scene's nodes place"},
    {Limit::triangles, "triangles", one << 26, "triangles of a scene, counted in every instance"},
    {Limit::vertices, "vertices", one << 26, "vertices of a scene's meshes together"},
    {Limit::cameras, "cameras", 4096, "cameras of a scene"},
    {Limit::lights, "lights", 4096, "lights of a scene"},
    {Limit::texture_pixels, "texture_pixels", one << 26, "pixels of one texture of a scene"},
    {Limit::texture_bytes, "texture_bytes", one << 30,
     "bytes of all textures of a scene in memory, 12 a pixel, with alpha 16"},
    {Limit::probe_pixels, "probe_pixels", one << 27, "pixels of a probe"},
    {Limit::image_pixels, "image_pixels", one << 28, "pixels of a cell or any other image"},
    {Limit::image_channels, "image_channels", 1024, "channels of an image"},
    {Limit::image_bytes, "image_bytes", one << 33, "bytes of an image in memory, 4 a value"},
    {Limit::image_expansion, "image_expansion", one << 16,
     "bytes that each byte of an image file may stand for"},
});

using Values = std::array<std::uint64_t, declared.size()>;

constexpr bool in_order() {
  for (std::size_t i = 0; i < declared.size(); ++i) {
    if (std::size_t(declared[i].limit) != i) return false;
  }
  return true;
}
static_assert(in_order());

std::size_t index_of(std::string_view name, const std::string& source) {
  std::vector<std::string> names;
  for (const LimitInfo& info : declared) {
    if (info.name == name) return std::size_t(info.limit);
    names.emplace_back(info.name);
  }
  throw InputError(
      fmt::format("{}: unknown limit '{}'{}", source, name, accepted_words(name, names)));
}

Values parse(std::string_view text, const std::string& source) {
  Values values{};
  for (const LimitInfo& info : declared) values[std::size_t(info.limit)] = info.default_value;
  while (!text.empty()) {
    const std::string_view entry = text.substr(0, text.find(','));
    text.remove_prefix(std::min(entry.size() + 1, text.size()));
    const std::size_t equals = entry.find('=');
    std::uint64_t value = 0;
    const std::string_view digits =
        equals == std::string_view::npos ? std::string_view() : entry.substr(equals + 1);
    const auto [rest, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (digits.empty() || error != std::errc() || rest != digits.data() + digits.size()) {
      throw InputError(fmt::format("{}: found '{}'; accepted: NAME=INTEGER, separated by commas",
                                   source, entry));
    }
    values[index_of(entry.substr(0, equals), source)] = value;
  }
  return values;
}

Values& values_in_force() {
  static Values values = [] {
    const char* text = std::getenv("OCCLAB_LIMITS");
    return parse(text == nullptr ? "" : text, "environment variable OCCLAB_LIMITS");
  }();
  return values;
}

}  // namespace

std::span<const LimitInfo> limits() { return declared; }

std::uint64_t limit(Limit which) { return values_in_force()[std::size_t(which)]; }

void set_limits(std::string_view text) { values_in_force() = parse(text, "limits"); }

void require_within(Limit which, std::uint64_t found, std::string_view what,
                    const std::string& where) {
  const std::uint64_t most = limit(which);
  if (found <= most) return;
  throw InputError(fmt::format("{}: {} {}; accepted: up to {} (limit {}, see OCCLAB_LIMITS)", where,
                               found, what, most, declared[std::size_t(which)].name));
}

std::uint64_t saturating_add(std::uint64_t a, std::uint64_t b) {
  const std::uint64_t sum = a + b;
  return sum < a ? std::numeric_limits<std::uint64_t>::max() : sum;
}

std::uint64_t saturating_multiply(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
  return a != 0 && b > most / a ? most : a * b;
}

}  // namespace occlab
