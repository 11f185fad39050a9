#include "harness/config.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "harness/config_parts.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

using Methods = std::vector<MethodInfo>;

SceneSettings read_scene(TomlTable table) {
  SceneSettings scene;
  scene.source = table.name_or_path("source");
  scene.view = table.text("view", "");
  if (table.has("resolution")) {
    const TomlTable::Numbers size = table.numbers("resolution", 2);
    const auto accepted = [](double length) { return length >= 16 && length <= 16384; };
    if (!size.whole || !std::ranges::all_of(size.values, accepted)) {
      table.fail("resolution", "accepted are two integers in [16, 16384], width and height");
    }
    scene.width = int(size.values[0]);
    scene.height = int(size.values[1]);
  }
  table.refuse_others();
  return scene;
}

ProbeSettings read_probe(TomlTable table) {
  ProbeSettings probe;
  probe.source = table.name_or_path("source");
  probe.rotation_degrees = float(table.real("rotation_degrees", -360, 360, 0.0));
  probe.exposure_stops = float(table.real("exposure_stops", -32, 32, 0.0));
  probe.prefilter_degrees = float(table.real("prefilter_degrees", 0, 90, 0.0));
  table.refuse_others();
  return probe;
}

ReferenceSettings read_reference(TomlTable table, const Methods& methods) {
  ReferenceSettings reference;
  reference.method = table.text("method");
  const auto known = known_methods(table, "method", {reference.method}, methods);
  reference.tolerance = table.real("tolerance", 1e-4, 10.0, 0.1);
  if (table.has("max_rays_per_pixel")) {
    reference.max_rays_per_pixel = table.integer("max_rays_per_pixel", 1, 1 << 24, std::nullopt);
  }
  reference.parameters = single_values(read_parameters(table, known, {.own_seed = true}));
  return reference;
}

RunSettings read_run(TomlTable& table, const Methods& methods) {
  RunSettings run;
  run.methods = table.words("methods");
  const auto known = known_methods(table, "methods", run.methods, methods);
  run.seeds = int(table.integer("seeds", 1, 4096, 1));
  run.axes = read_parameters(table, known, {.lists = true, .by_all = true});
  for (const MethodInfo* method : known) {
    if (run.seeds > 1 && !declares(*method, "seed")) {
      table.fail("seeds", fmt::format("method '{}' has no seed; accepted is 1", method->name));
    }
  }
  return run;
}

BudgetSettings read_budget(TomlTable table) {
  BudgetSettings budget;
  budget.tolerance = table.real("tolerance", 1e-5, 1.0, budget.tolerance);
  budget.budget_seconds = table.real("budget_seconds", 0.0, 86400, budget.budget_seconds);
  table.refuse_others();
  return budget;
}

/// Two runs that make the same cell would count it twice, and a test that is the reference itself
/// would have no error.
void refuse_equal_cells(const Experiment& experiment, const std::vector<TomlTable>& run_tables,
                        const Methods& methods) {
  std::map<std::string, std::string> makers;
  const auto text = [](const PlannedCell& cell) {
    return cell.method + " " + cell.parameters.to_string();
  };
  Experiment part = experiment;
  part.runs.clear();
  for (const PlannedCell& cell : plan(part, methods)) makers[text(cell)] = "the reference";
  part.reference.reset();
  for (std::size_t i = 0; i < experiment.runs.size(); ++i) {
    part.runs = {experiment.runs[i]};
    for (const PlannedCell& cell : plan(part, methods)) {
      const auto [maker, is_new] = makers.emplace(text(cell), fmt::format("run[{}]", i));
      if (!is_new) {
        run_tables[i].fail(
            "methods", fmt::format("the cell '{}' is also made by {}", text(cell), maker->second));
      }
    }
  }
}

/// max_rays_per_pixel goes on from rays_per_pixel.
void check_ray_budget(const ReferenceSettings& reference, const ParameterSet& parameters,
                      const TomlTable& table) {
  if (!reference.max_rays_per_pixel) return;
  if (!parameters.has("rays_per_pixel") || !parameters.has("seed")) {
    table.fail("max_rays_per_pixel", "method '" + reference.method + "' does not trace rays");
  }
  if (const long first = parameters.integer("rays_per_pixel");
      *reference.max_rays_per_pixel < first) {
    table.fail("max_rays_per_pixel",
               fmt::format("accepted are at least rays_per_pixel, {}", first));
  }
}

}  // namespace

Experiment load_experiment(const std::filesystem::path& path,
                           const std::vector<std::string>& overrides, const Methods& methods) {
  const toml::table document = parse_toml(path, overrides);
  TomlTable root(document, "", path.string());
  Experiment experiment;
  experiment.file = path;
  std::ostringstream resolved;
  resolved << document << "\n";
  experiment.resolved = resolved.str();

  root.integer("format", 1, 1, std::nullopt);
  TomlTable names = root.table("experiment");
  experiment.name = names.identifier("name");
  experiment.title = names.text("title");
  names.refuse_others();
  experiment.scene = read_scene(root.table("scene"));
  if (root.has("probe")) experiment.probe = read_probe(root.table("probe"));
  if (root.has("reference")) {
    experiment.reference = read_reference(root.table("reference"), methods);
  }
  // A file may be there for its times alone.
  std::vector<TomlTable> run_tables;
  if (root.has("run") || !root.has("timing")) run_tables = root.tables("run");
  for (TomlTable& table : run_tables) experiment.runs.push_back(read_run(table, methods));
  if (root.has("budget")) {
    if (!experiment.reference) root.fail("budget", "an error budget needs a [reference]");
    experiment.budget = read_budget(root.table("budget"));
  }
  if (root.has("timing")) experiment.timing = read_timing(root.table("timing"), methods);

  // [parameters] may name what any method of the file declares.
  std::vector<const MethodInfo*> used;
  for (const MethodInfo& method : methods) {
    const auto lists = [&](const auto& part) {
      return std::ranges::find(part.methods, method.name) != part.methods.end();
    };
    if ((experiment.reference && experiment.reference->method == method.name) ||
        std::ranges::any_of(experiment.runs, lists) ||
        (experiment.timing && lists(*experiment.timing))) {
      used.push_back(&method);
    }
  }
  if (root.has("parameters")) {
    TomlTable table = root.table("parameters");
    experiment.parameters = single_values(read_parameters(table, used, {}));
  }
  refuse_equal_cells(experiment, run_tables, methods);
  if (experiment.reference) {
    check_ray_budget(*experiment.reference, plan(experiment, methods).front().parameters,
                     root.table("reference"));
  }

  if (root.has("figure")) {
    const std::vector<PlannedCell> cells = plan(experiment, methods);
    for (TomlTable& table : root.tables("figure")) {
      FigureSettings figure =
          read_figure(table, {experiment.scene, methods, cells, experiment.budget.has_value()});
      if (std::ranges::find(experiment.figures, figure.name, &FigureSettings::name) !=
          experiment.figures.end()) {
        table.fail("name", fmt::format("two figures are called '{}'", figure.name));
      }
      experiment.figures.push_back(std::move(figure));
    }
  }
  root.refuse_others();
  return experiment;
}

}  // namespace occlab
