#include "harness/config.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <sstream>

#include "harness/config_parts.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

using Methods = std::vector<MethodInfo>;

ReferenceSettings read_reference(TomlTable table, const Methods& methods) {
  ReferenceSettings reference;
  std::vector<std::string> names =
      table.is_list("method") ? table.words("method") : std::vector{table.text("method")};
  const auto known = known_methods(table, "method", names, methods);
  reference.method = names.front();
  reference.others.assign(names.begin() + 1, names.end());
  reference.tolerance = table.real("tolerance", 1e-4, 10.0, 0.1);
  if (table.has("max_rays_per_pixel")) {
    reference.max_rays_per_pixel = table.integer("max_rays_per_pixel", 1, 1 << 24, std::nullopt);
  }
  reference.parameters = single_values(read_parameters(table, known, {.own_seed = true}));
  return reference;
}

bool is_reference(const ReferenceSettings& reference, const std::string& method) {
  return reference.method == method ||
         std::ranges::find(reference.others, method) != reference.others.end();
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

/// With several references every method is compared with its own.
void check_truths(const std::vector<PlannedCell>& cells, const ReferenceSettings& reference,
                  const TomlTable& table) {
  if (reference.others.empty()) return;
  for (const PlannedCell& cell : cells) {
    if (cell.role == Role::reference || cells[reference_place(cells, cell)].method == cell.truth) {
      continue;
    }
    table.fail("method", fmt::format("of several references every method needs its own; that of "
                                     "'{}' is '{}'",
                                     cell.method, cell.truth));
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

void check_cells(const Experiment& experiment, const TomlTable& root, const Methods& methods) {
  const long cells = std::ssize(plan(experiment, methods));
  long all = 0;
  if (__builtin_mul_overflow(cells, std::ssize(experiment.benches), &all)) {
    all = std::numeric_limits<long>::max();
  }
  check_count(root, "scene", all,
              fmt::format("{} scenes, views, resolutions and probes of {} cells each",
                          experiment.benches.size(), cells));
}

/// Times have axes of their own.
void refuse_timing_of_several_benches(const Experiment& experiment, TomlTable& root) {
  if (experiment.benches.size() == 1 || !root.has("timing")) return;
  root.fail("timing", fmt::format("accepted with one scene, view, resolution and probe; [scene] "
                                  "and [probe] make {}",
                                  experiment.benches.size()));
}

}  // namespace

Experiment at_bench(const Experiment& experiment, const BenchSettings& bench) {
  Experiment one = experiment;
  one.scene = bench.scene;
  one.probe = bench.probe;
  one.benches = {bench};
  std::erase_if(one.figures, [&](const FigureSettings& figure) {
    return figure.kind == FigureKind::grid || experiment.benches[figure.bench].point != bench.point;
  });
  for (FigureSettings& figure : one.figures) figure.bench = 0;
  return one;
}

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
  experiment.benches = read_benches(root);
  experiment.scene = experiment.benches.front().scene;
  experiment.probe = experiment.benches.front().probe;
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
    if ((experiment.reference && is_reference(*experiment.reference, method.name)) ||
        std::ranges::any_of(experiment.runs, lists) ||
        (experiment.timing && lists(*experiment.timing))) {
      used.push_back(&method);
    }
  }
  if (root.has("parameters")) {
    TomlTable table = root.table("parameters");
    experiment.parameters = single_values(read_parameters(table, used, {}));
  }
  check_cells(experiment, root, methods);
  refuse_equal_cells(experiment, run_tables, methods);
  refuse_timing_of_several_benches(experiment, root);
  if (experiment.reference) {
    const std::vector<PlannedCell> cells = plan(experiment, methods);
    check_truths(cells, *experiment.reference, root.table("reference"));
    check_ray_budget(*experiment.reference, cells.front().parameters, root.table("reference"));
  }

  if (root.has("region")) {
    for (TomlTable& table : root.tables("region")) read_region(table, experiment.benches);
  }
  if (root.has("figure")) {
    const std::vector<PlannedCell> cells = plan(experiment, methods);
    for (TomlTable& table : root.tables("figure")) {
      FigureSettings figure =
          read_figure(table, {experiment.benches, methods, cells, experiment.budget.has_value()});
      if (std::ranges::find(experiment.figures, figure.name, &FigureSettings::name) !=
          experiment.figures.end()) {
        table.fail("name", fmt::format("two figures are called '{}'", figure.name));
      }
      add_regions(table, figure, experiment.benches);
      experiment.figures.push_back(std::move(figure));
    }
  }
  root.refuse_others();
  return experiment;
}

}  // namespace occlab
