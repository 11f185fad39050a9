#include "harness/verify/analytic_cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "harness/verify/analytic_sky.h"
#include "renderers/methods/method.h"
#include "renderers/scene/error.h"
#include "renderers/scene/gltf_file.h"

namespace occlab {
namespace {

constexpr int default_seeds = 32;

int integer_between(const JsonValue& value, std::uint64_t low, std::uint64_t high) {
  const std::uint64_t found = value.unsigned_integer();
  if (found < low || found > high) {
    value.fail(fmt::format("found {}; accepted: an integer in [{}, {}]", found, low, high));
  }
  return int(found);
}

glm::vec3 vector_of(const JsonValue& value) {
  const std::vector<double> v = value.numbers(3);
  return {float(v[0]), float(v[1]), float(v[2])};
}

glm::vec3 unit_vector(const JsonValue& value) {
  const glm::vec3 v = vector_of(value);
  if (!(std::abs(glm::length(v) - 1.0f) < 1e-4f)) {
    value.fail(
        fmt::format("found a vector of length {:g}; accepted: a unit vector", glm::length(v)));
  }
  return glm::normalize(v);
}

AnalyticPoint read_point(const JsonValue& value) {
  value.require_keys({"position", "normal", "geometric_normal"});
  AnalyticPoint point;
  point.position = vector_of(value.at("position"));
  point.normal = unit_vector(value.at("normal"));
  const auto geometric = value.find("geometric_normal");
  point.geometric_normal = geometric ? unit_vector(*geometric) : point.normal;
  return point;
}

AnalyticRegion read_region(const JsonValue& value) {
  value.require_keys({"camera", "resolution", "pixels"});
  AnalyticRegion region;
  region.camera = value.at("camera").text();
  const JsonValue resolution = value.at("resolution");
  if (resolution.array_size() != 2) resolution.fail("accepted: [width, height]");
  region.width = integer_between(resolution.element(0), 1, 4096);
  region.height = integer_between(resolution.element(1), 1, 4096);
  region.columns = region.width;
  region.rows = region.height;
  if (const auto pixels = value.find("pixels")) {
    if (pixels->array_size() != 4) pixels->fail("accepted: [x, y, columns, rows]");
    region.x = integer_between(pixels->element(0), 0, std::uint64_t(region.width) - 1);
    region.y = integer_between(pixels->element(1), 0, std::uint64_t(region.height) - 1);
    region.columns = integer_between(pixels->element(2), 1, std::uint64_t(region.width - region.x));
    region.rows = integer_between(pixels->element(3), 1, std::uint64_t(region.height - region.y));
  }
  return region;
}

/// The layer must be one of the method's, the settings must be ones it takes.
AnalyticQuantity read_quantity(const JsonValue& method_name, const JsonValue& layer,
                               const std::vector<JsonValue>& settings) {
  AnalyticQuantity quantity{.method = method_name.text(), .layer = layer.text(), .settings = {}};
  std::vector<std::string> layers = {"radiance"};
  try {
    std::ranges::copy(find_method(quantity.method).layers, std::back_inserter(layers));
  } catch (const InputError& error) {
    method_name.fail(error.what());
  }
  if (std::ranges::find(layers, quantity.layer) == layers.end()) {
    layer.fail(fmt::format("'{}' is no layer of {}{}", quantity.layer, quantity.method,
                           accepted_words(quantity.layer, layers)));
  }
  for (const JsonValue& setting : settings) {
    quantity.settings.push_back(setting.text());
    try {
      quantity.parameters();
    } catch (const InputError& error) {
      setting.fail(error.what());
    }
  }
  return quantity;
}

class CaseReader {
 public:
  CaseReader(AnalyticFile& file, const JsonValue& cases)
      : file_(file), stem_(file.path.stem().string()), cases_(cases) {}

  void read_all() {
    if (cases_.array_size() == 0) cases_.fail("is empty; accepted: at least one case");
    for (std::size_t i = 0; i < cases_.array_size(); ++i) read(cases_.element(i));
  }

 private:
  void read(const JsonValue& json) {
    json.require_keys({"name", "source", "methods", "quantity", "set", "point", "view", "sky",
                       "seeds", "expected", "equals", "same_under", "bound", "bound_source"});
    AnalyticCase common;
    common.place = json.where();
    common.name = fmt::format("{}: {}", stem_, json.at("name").text());
    common.source = json.at("source").text();
    read_place(json, common);
    common.sky = sky(json.at("sky"));
    read_expectation(json, common);
    read_bound(json, common);
    const JsonValue methods = json.at("methods");
    if (methods.array_size() == 0) methods.fail("is empty; accepted: at least one method");
    for (std::size_t i = 0; i < methods.array_size(); ++i) {
      AnalyticCase one = common;
      one.quantity = read_quantity(methods.element(i), json.at("quantity"), json.array("set"));
      check_quantity(json, one);
      file_.cases.push_back(std::move(one));
    }
  }

  static void read_place(const JsonValue& json, AnalyticCase& one) {
    const auto point = json.find("point");
    const auto view = json.find("view");
    if (point.has_value() == view.has_value()) {
      json.fail(fmt::format("{} of the keys 'point' and 'view'; accepted: one of them",
                            point ? "both" : "neither"));
    }
    if (point) one.point = read_point(*point);
    if (view) one.region = read_region(*view);
  }

  static void read_expectation(const JsonValue& json, AnalyticCase& one) {
    const auto expected = json.find("expected");
    const auto equals = json.find("equals");
    const auto same = json.find("same_under");
    if (int(expected.has_value()) + int(equals.has_value()) + int(same.has_value()) != 1) {
      json.fail("accepted: exactly one of the keys 'expected', 'equals' and 'same_under'");
    }
    one.seeds = default_seeds;
    if (const auto seeds = json.find("seeds")) one.seeds = integer_between(*seeds, 4, 4096);
    if (expected) {
      one.expected = expected->numbers(expected->array_size());
      if (one.expected.empty()) expected->fail("is empty; accepted: one number a channel");
    } else if (equals) {
      one.expectation = Expectation::equals;
      one.seeds = 1;
      equals->require_keys({"method", "quantity", "set"});
      one.other = read_quantity(equals->at("method"), equals->at("quantity"), equals->array("set"));
    } else {
      static const std::map<std::string, Expectation> words = {{"turn", Expectation::turned},
                                                               {"roll", Expectation::rolled},
                                                               {"mirror", Expectation::mirrored}};
      const auto word = words.find(same->text());
      if (word == words.end()) {
        same->fail(fmt::format("found '{}'; accepted: turn, roll, mirror", same->text()));
      }
      one.expectation = word->second;
      if (one.point) json.fail("'same_under' needs a 'view'");
    }
  }

  static void read_bound(const JsonValue& json, AnalyticCase& one) {
    const JsonValue bound = json.at("bound");
    one.bound = bound.number();
    if (one.bound < 0.0) bound.fail(fmt::format("found {:g}; accepted: at least 0", one.bound));
    if (one.bound > 0.0) one.bound_source = json.at("bound_source").text();
  }

  /// Only the ray tracer shades points that no camera sees; a mirror image has other axes.
  static void check_quantity(const JsonValue& json, const AnalyticCase& one) {
    if (one.quantity.is_directional() && json.find("same_under")) {
      json.at("quantity").fail("belongs to axes, which 'same_under' changes");
    }
    if (one.point && find_method(one.quantity.method).representation) {
      json.at("point").fail(
          fmt::format("{} shades the pixels of a 'view', not a point", one.quantity.method));
    }
  }

  std::shared_ptr<const Environment> sky(const JsonValue& json) {
    auto made = std::make_shared<const Environment>(read_analytic_sky(json));
    return skies_.try_emplace(made->name, std::move(made)).first->second;
  }

  AnalyticFile& file_;
  std::string stem_;
  JsonValue cases_;
  std::map<std::string, std::shared_ptr<const Environment>> skies_;
};

}  // namespace

ParameterSet AnalyticQuantity::parameters() const {
  ParameterSet values(find_method(method).parameters);
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos) {
      throw InputError(fmt::format("found '{}'; accepted: NAME=VALUE", setting));
    }
    values.set_text(setting.substr(0, equals), setting.substr(equals + 1));
  }
  return values;
}

AnalyticFile read_analytic_file(const std::filesystem::path& path) {
  const GltfFile gltf(path);
  AnalyticFile file{.path = path, .cases = {}};
  const auto& scenes = gltf.list("scenes");
  if (scenes.empty()) gltf.root().fail("has no scene");
  const JsonValue verify = scenes.front().at("extras").at("occlab_verify");
  verify.require_keys({"format", "cases"});
  const JsonValue format = verify.at("format");
  if (format.unsigned_integer() != 1) {
    format.fail(fmt::format("found {}; accepted: 1", format.unsigned_integer()));
  }
  CaseReader(file, verify.at("cases")).read_all();
  return file;
}

std::vector<std::filesystem::path> analytic_files(const std::filesystem::path& folder_or_file) {
  if (!std::filesystem::is_directory(folder_or_file)) return {folder_or_file};
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder_or_file)) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".glb" || extension == ".gltf") files.push_back(entry.path());
  }
  if (files.empty()) {
    throw InputError(fmt::format("{}: holds no .glb or .gltf file", folder_or_file.string()));
  }
  std::ranges::sort(files);
  return files;
}

}  // namespace occlab
