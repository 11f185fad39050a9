#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "harness/metrics/metrics.h"
#include "harness/verbs/verbs.h"
#include "renderers/scene/error.h"
#include "renderers/scene/image_io.h"

namespace occlab {
namespace {

struct CompareOptions {
  std::string reference;
  std::string test;
  std::string layer = "radiance";
  std::string reference_layer = "radiance";
  bool json = false;
};

/// The named layer of an occlab EXR, or the only colours of any other EXR.
const Image& colours(const ExrFile& file, const std::string& layer, const std::string& path) {
  if (const Image* image = file.layers.find(layer)) return *image;
  const Image* plain = file.layers.find("");
  if (plain && plain->channels() == 3) return *plain;
  try {
    return file.layers.at(layer);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", path, error.what()));
  }
}

int compare(const CompareOptions& options) {
  const ExrFile reference = read_exr(options.reference);
  const ExrFile test = read_exr(options.test);
  const Image& image = colours(reference, options.reference_layer, options.reference);
  const Image* mask = reference.layers.find("mask");
  const Image everywhere(image.width(), image.height(), 1, 1.0f);
  std::vector<MetricValue> values;
  try {
    values = measure({.reference = image,
                      .test = colours(test, options.layer, options.test),
                      .mask = mask ? *mask : everywhere,
                      .reference_occlusion = reference.layers.find("ambient_occlusion"),
                      .reference_variance = reference.layers.find("radiance_variance")});
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("{} against {}: {}", options.test, options.reference, error.what()));
  }
  nlohmann::json json = nlohmann::json::array();
  for (const MetricValue& metric : values) {
    if (options.json) {
      nlohmann::json entry = {
          {"metric", metric.name}, {"unit", metric.unit}, {"pixels", metric.pixels}};
      if (!metric.value) {
        entry["value"] = nullptr;
        entry["reason"] = metric.reason;
      } else if (std::isfinite(*metric.value)) {
        entry["value"] = *metric.value;
      } else {
        entry["value"] = "inf";
      }
      json.push_back(std::move(entry));
    } else if (metric.value) {
      fmt::print("{:<32} {:>12.6g} {}\n", metric.name, *metric.value, metric.unit);
    } else {
      fmt::print("{:<32} {:>12} could not measure: {}\n", metric.name, "-", metric.reason);
    }
  }
  if (options.json) fmt::print("{}\n", json.dump(2));
  return exit_good;
}

}  // namespace

void add_compare_verb(CLI::App& app, Action& action) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* verb = app.add_subcommand(
      "compare",
      "all metrics of an image against a reference; mask, occlusion and variance are the "
      "reference's own layers where it has them");
  verb->add_option("reference", options->reference, "EXR")->required();
  verb->add_option("test", options->test, "EXR")->required();
  verb->add_option("--layer", options->layer, "the test's layer, such as radiance_unfiltered")
      ->capture_default_str();
  verb->add_option("--reference-layer", options->reference_layer, "the reference's layer")
      ->capture_default_str();
  verb->add_flag("--json", options->json, "print JSON");
  verb->callback([options, &action] { action = [options] { return compare(*options); }; });
}

}  // namespace occlab
