#include "renderers/scene/environment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "renderers/scene/data_root.h"
#include "renderers/scene/error.h"
#include "renderers/scene/image_io.h"
#include "renderers/shared/equirect.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

/// Lossy compression of Blender's studio lights reaches -0.004.
constexpr float most_negative_accepted = -0.01f;

std::vector<ProbeName> probes_in(const fs::path& folder) {
  std::vector<ProbeName> probes;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const fs::path& path = entry.path();
    if (path.extension() == ".exr" || path.extension() == ".hdr") {
      probes.push_back({path.stem().string(), path});
    }
  }
  std::ranges::sort(probes, {}, &ProbeName::name);
  return probes;
}

std::vector<fs::path> blender_datafiles() {
  const auto variable = [](const char* name) -> const char* {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0' ? value : nullptr;
  };
  if (const char* ours = variable("OCCLAB_BLENDER_DATAFILES")) return {ours};
  std::vector<fs::path> folders;
  if (const char* blender = variable("BLENDER_SYSTEM_DATAFILES")) folders.emplace_back(blender);
  const fs::path installed = "/usr/share/blender";
  folders.push_back(installed / "datafiles");
  std::vector<fs::path> versions;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(installed, ignored)) {
    versions.push_back(entry.path() / "datafiles");
  }
  std::ranges::sort(versions, std::ranges::greater{});  // the newest version first
  folders.insert(folders.end(), versions.begin(), versions.end());
  return folders;
}

fs::path find_probe(const std::string& source) {
  if (source.empty()) throw InputError("probe: the name is empty; accepted: a name or a path");
  if (is_path(source)) return source;
  std::vector<std::string> names;
  for (const ProbeName& probe : probe_names()) {
    if (probe.name == source) return probe.path;
    names.push_back(probe.name);
  }
  throw InputError(fmt::format(
      "unknown probe '{}' (looked in {} and Blender's studio lights){}; a path of an "
      ".exr or .hdr is accepted too",
      source, (data_root() / "scenes" / "probes").string(), accepted_words(source, names)));
}

void check_settings(const ProbeSettings& settings) {
  const auto check = [&](const char* key, float value, float low, float high) {
    if (!(value >= low && value <= high)) {
      throw InputError(fmt::format("probe '{}': {}: found {:g}; accepted: {:g} to {:g}",
                                   settings.source, key, value, low, high));
    }
  };
  check("rotation_degrees", settings.rotation_degrees, -36000.0f, 36000.0f);
  check("exposure_stops", settings.exposure_stops, -64.0f, 64.0f);
  check("prefilter_degrees", settings.prefilter_degrees, 0.0f, 180.0f);
}

/// Fails on what is no equirect radiance; clamps small negative values and returns how many texels
/// had one.
std::size_t check_texels(const fs::path& path, Image& texels) {
  const auto fail = [&](const std::string& reason) {
    throw InputError(fmt::format("{}: {}", path.string(), reason));
  };
  if (texels.width() != 2 * texels.height()) {
    fail(fmt::format("{}x{}; an equirectangular probe is twice as wide as high", texels.width(),
                     texels.height()));
  }
  std::size_t bad = 0;
  std::size_t too_negative = 0;
  std::size_t clamped = 0;
  std::string first_bad;
  std::string first_negative;
  for (int y = 0; y < texels.height(); ++y) {
    for (int x = 0; x < texels.width(); ++x) {
      const auto texel = texels.pixel(x, y);
      const auto describe = [&] {
        return fmt::format("column {}, row {} ({:g}, {:g}, {:g})", x, y, texel[0], texel[1],
                           texel[2]);
      };
      if (std::ranges::any_of(texel, [](float v) { return !std::isfinite(v); })) {
        if (bad++ == 0) first_bad = describe();
        continue;
      }
      const float least = std::ranges::min(texel);
      if (least < most_negative_accepted && too_negative++ == 0) first_negative = describe();
      if (least < 0.0f) {
        ++clamped;
        for (float& value : texel) value = std::max(value, 0.0f);
      }
    }
  }
  if (bad > 0) {
    fail(
        fmt::format("{} of {} texels are NaN or infinite, the first in {}; only finite radiance is "
                    "accepted",
                    bad, texels.pixel_count(), first_bad));
  }
  if (too_negative > 0) {
    fail(fmt::format("{} of {} texels are below {:g}, the first in {}; radiance is not negative",
                     too_negative, texels.pixel_count(), most_negative_accepted, first_negative));
  }
  return clamped;
}

}  // namespace

double texel_solid_angle(const Image& texels, int row) {
  const double step = std::numbers::pi / texels.height();
  return 2.0 * std::numbers::pi / texels.width() *
         (std::cos(row * step) - std::cos((row + 1) * step));
}

glm::ivec2 Environment::texel(glm::vec3 direction_world) const {
  const glm::vec2 uv = equirect_uv(probe_from_world * direction_world);
  // u = 1 is u = 0; v = 1 is the last row.
  const int x = int(uv.x * float(texels.width())) % texels.width();
  const int y = std::min(int(uv.y * float(texels.height())), texels.height() - 1);
  return {x, y};
}

glm::vec3 Environment::radiance(glm::vec3 direction_world) const {
  const glm::ivec2 t = texel(direction_world);
  const auto value = texels.pixel(t.x, t.y);
  return {value[0], value[1], value[2]};
}

std::vector<ProbeName> probe_names() {
  std::vector<ProbeName> names = probes_in(data_root() / "scenes" / "probes");
  for (const fs::path& folder : blender_datafiles()) {
    const std::vector<ProbeName> lights = probes_in(folder / "studiolights" / "world");
    for (const ProbeName& light : lights) {
      if (std::ranges::find(names, light.name, &ProbeName::name) == names.end()) {
        names.push_back(light);
      }
    }
    if (!lights.empty()) break;
  }
  return names;
}

Environment load_environment(const ProbeSettings& settings) {
  check_settings(settings);
  const fs::path path = find_probe(settings.source);
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return char(std::tolower(c)); });
  if (extension != ".exr" && extension != ".hdr") {
    throw InputError(
        fmt::format("{}: a probe must be an .exr or .hdr with linear radiance", path.string()));
  }

  Environment environment;
  environment.name = path.stem().string();
  environment.texels = read_rgb(path, Limit::probe_pixels);
  environment.clamped_negative_texels = check_texels(path, environment.texels);
  const float exposure = std::exp2(settings.exposure_stops);
  for (float& value : environment.texels.values()) {
    value *= exposure;
    if (!std::isfinite(value)) {
      throw InputError(
          fmt::format("probe '{}': exposure_stops {:g} takes a texel beyond the range "
                      "of float",
                      settings.source, settings.exposure_stops));
    }
  }
  if (settings.prefilter_degrees > 0.0f) {
    environment.texels = prefilter_gaussian(environment.texels, settings.prefilter_degrees);
    environment.blur_degrees = settings.prefilter_degrees;
  }

  // World direction of a probe direction: R_y(t), which is counter-clockwise seen from +Y.
  const double t = std::numbers::pi / 180.0 * std::fmod(double(settings.rotation_degrees), 360.0);
  const auto c = float(std::cos(t));
  const auto s = float(std::sin(t));
  environment.probe_from_world =
      glm::mat3(glm::vec3(c, 0.0f, s), glm::vec3(0.0f, 1.0f, 0.0f), glm::vec3(-s, 0.0f, c));
  return environment;
}

Environment constant_environment(glm::vec3 radiance) {
  Environment environment;
  environment.name = "constant";
  environment.texels = Image(64, 32, 3);
  for (std::size_t i = 0; i < environment.texels.values().size(); ++i) {
    environment.texels.values()[i] = radiance[int(i % 3)];
  }
  return environment;
}

}  // namespace occlab
