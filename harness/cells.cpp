#include "harness/cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>

#include "harness/files.h"
#include "harness/version.h"
#include "renderers/gl/program.h"

namespace occlab {
std::vector<std::pair<std::string, std::string>> named_parameters(const ParameterSet& parameters) {
  std::vector<std::pair<std::string, std::string>> named;
  for (const Parameter& parameter : parameters.declared()) {
    if (parameter.name != "seed") {
      named.emplace_back(parameter.name, to_string(parameters.value(parameter.name)));
    }
  }
  return named;
}

namespace {

void drop_layers(Layers& layers, const std::vector<std::string>& names) {
  Layers kept;
  for (const Layers::Layer& layer : layers.all()) {
    if (std::ranges::find(names, layer.name) == names.end()) kept.add(layer.name, layer.image);
  }
  layers = std::move(kept);
}

/// Of a method's expanded shaders, which do not change while the program runs.
const std::string& hash_of_shaders(const std::string& method) {
  static std::map<std::string, std::string> known;
  const auto [entry, is_new] = known.try_emplace(method);
  if (is_new) {
    std::string shaders;
    for (const std::string& shader : find_method(method).shaders) {
      shaders += expand_shader(shader, "").text;
    }
    entry->second = sha256_text(shaders);
  }
  return entry->second;
}

}  // namespace

BenchFacts bench_facts(const Workbench& bench) {
  const View& view = bench.frame().view;
  return {.scene_hash = bench.scene_hash(),
          .view = view.camera.name,
          .resolution = {view.width, view.height},
          .probe_hash = bench.probe_hash(),
          .probe = bench.probe(),
          .device = bench.device().renderer,
          .driver = bench.device().version};
}

CellKey bench_key(const BenchFacts& facts) {
  const ProbeSettings& probe = facts.probe;
  CellKey key;
  key.add("scene", facts.scene_hash);
  key.add("view", facts.view);
  key.add("resolution", fmt::format("{}x{}", facts.resolution.width, facts.resolution.height));
  key.add("probe", facts.probe_hash);
  key.add("probe_settings",
          fmt::format("rotation_degrees={} exposure_stops={} prefilter_degrees={}",
                      probe.rotation_degrees, probe.exposure_stops, probe.prefilter_degrees));
  key.add("device", facts.device);
  key.add("driver", facts.driver);
  key.add("code", std::string(renderers_hash));
  return key;
}

CellKey workbench_key(const Workbench& bench) { return bench_key(bench_facts(bench)); }

CellKey cell_key(const BenchFacts& facts, const PlannedCell& cell) {
  CellKey key = bench_key(facts);
  key.add("method", cell.method);
  key.add("parameters", cell.parameters.to_string());
  key.add("shaders", hash_of_shaders(cell.method));
  return key;
}

CellKey cell_key(const Workbench& bench, const PlannedCell& cell) {
  return cell_key(bench_facts(bench), cell);
}

Layers render_cell(Workbench& bench, const PlannedCell& cell, OcclusionMethod& method,
                   Metadata& facts) {
  const auto start = std::chrono::steady_clock::now();
  Layers layers = method.evaluate(bench.frame(), cell.parameters, facts);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  facts["wall_seconds"] = fmt::format("{:.3f}", elapsed.count());
  if (cell.role == Role::reference) {
    layers.add("mask", bench.frame().surface().mask);
  } else if (cell.parameters.has("seed") && cell.parameters.integer("seed") != 0) {
    drop_layers(layers, find_method(cell.method).layers);
  }
  return layers;
}

Metadata workbench_metadata(const Workbench& bench) {
  return {{"occlab:scene", bench.scene().path.filename().string()},
          {"occlab:view", bench.frame().view.camera.name},
          {"occlab:probe", describe(bench.probe())},
          {"occlab:device", bench.device().renderer},
          {"occlab:driver", bench.device().version},
          {"occlab:commit", std::string(build_commit)}};
}

Metadata cell_metadata(const Workbench& bench, const PlannedCell& cell, const Metadata& facts) {
  Metadata metadata = workbench_metadata(bench);
  metadata["occlab:method"] = cell.method;
  metadata["occlab:parameters"] = cell.parameters.to_string();
  for (const auto& [name, value] : facts) metadata["occlab:" + name] = value;
  return metadata;
}

}  // namespace occlab
