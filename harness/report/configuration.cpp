#include "harness/report/configuration.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>

#include "harness/files.h"
#include "harness/toml_limits.h"
#include "renderers/scene/data_root.h"
#include "renderers/scene/environment.h"
#include "renderers/scene/error.h"
#include "renderers/scene/view.h"

namespace occlab::report {
namespace {

using nlohmann::json;

toml::table parse(const std::string& configuration) {
  try {
    check_toml_text(configuration, "run.json: configuration");
    return toml::parse(configuration);
  } catch (const toml::parse_error&) {
    return {};
  } catch (const InputError&) {
    return {};
  }
}

std::string text_at(const toml::table& table, std::string_view key) {
  return table[key].value_or(std::string());
}

json texts_at(const toml::table& table, std::string_view key) {
  json texts = json::array();
  if (const toml::array* array = table[key].as_array()) {
    for (const toml::node& text : *array) texts.push_back(text.value_or(std::string()));
  }
  return texts;
}

template <typename Use>
void for_each_table(const toml::node_view<const toml::node>& list, const Use& use) {
  const toml::array* array = list.as_array();
  if (!array) return;
  for (const toml::node& node : *array) {
    if (const toml::table* table = node.as_table()) use(*table);
  }
}

/// Four integers are pixels, otherwise all are fractions of the frame (configs/FORMAT.md).
json rectangle_of(const toml::table& row, int width, int height) {
  const toml::array* numbers = row["rectangle"].as_array();
  if (!numbers || numbers->size() != 4) return nullptr;
  const bool pixels = numbers->is_homogeneous<std::int64_t>();
  json rectangle = json::array();
  for (std::size_t i = 0; i < 4; ++i) {
    const double extent = pixels ? 1.0 : i % 2 == 0 ? width : height;
    rectangle.push_back(std::lround(extent * (*numbers)[i].value_or(0.0)));
  }
  return rectangle;
}

json selection_of(const toml::table& row) {
  json select = json::object();
  for (const auto& [key, value] : row) {
    const std::string name(key.str());
    if (name == "label" || name == "rectangle") continue;
    if (const auto integer = value.value_exact<std::int64_t>()) {
      select[name] = std::to_string(*integer);
    } else if (const auto number = value.value_exact<double>()) {
      select[name] = fmt::format("{}", *number);
    } else {
      select[name] = value.value_or(std::string());
    }
  }
  return select;
}

std::string probe_hash(const std::string& source) {
  for (const ProbeName& known : probe_names()) {
    if (known.name == source) return sha256_file(known.path);
  }
  return sha256_file(source);
}

json coefficients(const Sh4& sh) {
  json list = json::array();
  for (const glm::vec4& four : {sh.c0, sh.c1, sh.c2, sh.c3}) {
    for (int i = 0; i < 4; ++i) list.push_back(four[i]);
  }
  return list;
}

void require_fact(const NamedTexts& facts, const std::string& name, const std::string& found,
                  const std::string& file) {
  const std::string* fact = find_text(facts, name);
  if (fact && *fact == found) return;
  throw InputError(fmt::format("{} is not the file that the cells were made with", file));
}

json project_light(const toml::table& experiment, const NamedTexts& facts) {
  const std::string source = experiment["probe"]["source"].value_or(std::string());
  if (source.empty()) throw InputError("the light is the scene's own, not a probe");
  const std::filesystem::path scene_file =
      scene_path(experiment["scene"]["source"].value_or(std::string()));
  require_fact(facts, "scene", sha256_file(scene_file), scene_file.string());
  const std::string* settings = find_text(facts, "probe_settings");
  const NamedTexts values = parse_parameters(settings ? *settings : "");
  const auto setting = [&](const char* name) {
    const std::string* text = find_text(values, name);
    if (!text) throw InputError("a cell without the facts of its probe");
    return std::strtof(text->c_str(), nullptr);
  };
  const ProbeSettings probe{source, setting("rotation_degrees"), setting("exposure_stops"),
                            setting("prefilter_degrees")};
  const Environment environment = load_environment(probe);
  require_fact(facts, "probe", probe_hash(source), source);
  const std::string* view = find_text(facts, "view");
  const Scene scene = load_scene(scene_file);
  const View camera{find_camera(scene, view ? *view : "")};
  const ShRgb light = project_sh(environment, camera.world_from_view_rotation());
  json result = {{"sh", {coefficients(light.r), coefficients(light.g), coefficients(light.b)}}};
  if (!scene.lights.empty()) {
    result["note"] =
        fmt::format("of the probe alone, without the scene's {} lights", scene.lights.size());
  }
  return result;
}

}  // namespace

json figures_of(const std::string& configuration) {
  const toml::table experiment = parse(configuration);
  json figures = json::array();
  for_each_table(experiment["figure"], [&](const toml::table& figure) {
    figures.push_back({{"name", text_at(figure, "name")},
                       {"kind", text_at(figure, "kind")},
                       {"title", text_at(figure, "title")},
                       {"stage", figure["stage"].value_or(std::string("filtered"))},
                       {"scale", figure["scale"].value_or(0.0)},
                       {"methods", texts_at(figure, "methods")}});
  });
  return figures;
}

json closeups_of(const std::string& configuration, int width, int height) {
  const toml::table experiment = parse(configuration);
  json closeups = json::array();
  for_each_table(experiment["figure"], [&](const toml::table& figure) {
    for_each_table(figure["rows"], [&](const toml::table& row) {
      const json rectangle = rectangle_of(row, width, height);
      if (rectangle.is_null()) return;
      closeups.push_back({{"figure", text_at(figure, "name")},
                          {"stage", figure["stage"].value_or(std::string("filtered"))},
                          {"label", text_at(row, "label")},
                          {"rectangle", rectangle},
                          {"select", selection_of(row)}});
    });
  });
  return closeups;
}

json light_of(const std::string& configuration, const NamedTexts& facts) {
  try {
    return project_light(parse(configuration), facts);
  } catch (const InputError& error) {
    return {{"missing", error.what()}};
  }
}

}  // namespace occlab::report
