#include "harness/config.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "harness/error_budget.h"
#include "harness/published.h"
#include "harness/toml_reader.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

using Methods = std::vector<MethodInfo>;

bool declares(const MethodInfo& method, const std::string& parameter) {
  return std::ranges::find(method.parameters, parameter, &Parameter::name) !=
         method.parameters.end();
}

/// The methods named by `key`, each of which exists.
std::vector<const MethodInfo*> known_methods(const TomlTable& table, const std::string& key,
                                             const std::vector<std::string>& names,
                                             const Methods& methods) {
  std::vector<std::string> accepted;
  for (const MethodInfo& method : methods) accepted.push_back(method.name);
  std::vector<const MethodInfo*> result;
  for (const std::string& name : names) {
    const auto method = std::ranges::find(methods, name, &MethodInfo::name);
    if (method == methods.end()) {
      table.fail(key, fmt::format("unknown method '{}'{}", name, accepted_words(name, accepted)));
    }
    result.push_back(&*method);
  }
  return result;
}

std::vector<std::string> parameter_names(const std::vector<const MethodInfo*>& methods) {
  std::vector<std::string> names;
  for (const MethodInfo* method : methods) {
    for (const Parameter& parameter : method->parameters) {
      if (std::ranges::find(names, parameter.name) == names.end()) names.push_back(parameter.name);
    }
  }
  return names;
}

/// Words such as gbuffer_bits' 16 may be written as numbers.
bool is_choice(const std::vector<const MethodInfo*>& methods, const std::string& name) {
  return std::ranges::any_of(methods, [&](const MethodInfo* method) {
    return std::ranges::any_of(method->parameters, [&](const Parameter& parameter) {
      return parameter.name == name && parameter.kind == ParameterKind::choice;
    });
  });
}

/// How a table's parameters are asked for.
struct ParameterRules {
  bool lists = false;     ///< a list of values is an axis
  bool by_all = false;    ///< every method has to declare them, not just one
  bool own_seed = false;  ///< `seed` may be given
};

/// The keys that are left in a table: parameters of `methods`, with valid values.
std::vector<Axis> read_parameters(TomlTable& table, const std::vector<const MethodInfo*>& methods,
                                  const ParameterRules& rules) {
  std::vector<std::string> accepted = parameter_names(methods);
  if (!rules.own_seed) std::erase(accepted, "seed");
  std::vector<Axis> axes;
  for (const std::string& name : table.others()) {
    if (name == "seed" && !rules.own_seed) {
      table.fail(name, "not accepted here: [[run]] has 'seeds', [reference] its own 'seed'");
    }
    if (std::ranges::find(accepted, name) == accepted.end()) table.refuse_unknown(name, accepted);
    Axis axis{name, table.values(name, rules.lists)};
    if (is_choice(methods, name)) {
      for (ParameterValue& value : axis.values) value = to_string(value);
    }
    for (const MethodInfo* method : methods) {
      if (!declares(*method, name)) {
        if (!rules.by_all) continue;
        table.fail(name, fmt::format("method '{}' does not declare it{}", method->name,
                                     accepted_words(name, parameter_names({method}))));
      }
      ParameterSet values(method->parameters);
      try {
        for (const ParameterValue& value : axis.values) values.set(name, value);
      } catch (const InputError& error) {
        table.fail(name, error.what());
      }
    }
    axes.push_back(std::move(axis));
  }
  return axes;
}

NamedValues single_values(const std::vector<Axis>& axes) {
  NamedValues values;
  for (const Axis& axis : axes) values.emplace_back(axis.parameter, axis.values.front());
  return values;
}

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

TimingSettings read_timing(TomlTable table, const Methods& methods) {
  TimingSettings timing;
  timing.methods = table.words("methods");
  const auto known = known_methods(table, "methods", timing.methods, methods);
  timing.baseline = table.text("baseline");
  if (std::ranges::find(timing.methods, timing.baseline) == timing.methods.end()) {
    table.fail("baseline", fmt::format("'{}' is not one of timing.methods{}", timing.baseline,
                                       accepted_words(timing.baseline, timing.methods)));
  }
  timing.repetitions = int(table.integer("repetitions", 3, 100000, 7));
  timing.budget_seconds = table.real("budget_seconds", 0.1, 86400, 60.0);
  if (table.has("published")) {
    timing.published = table.identifier("published");
    if (const auto path = published_path(timing.published); !std::filesystem::exists(path)) {
      table.fail("published", fmt::format("there is no file {}", path.string()));
    }
  }
  timing.axes = read_parameters(table, known, {.lists = true, .by_all = true});
  return timing;
}

/// [x, y, width, height] inside the frame: integers are pixels, reals fractions of the frame.
Rectangle read_rectangle(TomlTable& table, const SceneSettings& scene) {
  const TomlTable::Numbers numbers = table.numbers("rectangle", 4);
  std::vector<double> r = numbers.values;
  if (!numbers.whole) {
    for (std::size_t i = 0; i < 4; ++i) {
      if (!(r[i] >= 0 && r[i] <= 1)) {
        table.fail("rectangle",
                   "accepted are four integers (pixels) or four reals in [0, 1] "
                   "(fractions of the frame)");
      }
    }
    // The corners are rounded, not the sizes, so that rectangles that touch still do.
    const auto pixel = [](double fraction, int size) { return std::round(fraction * size); };
    const double right = pixel(r[0] + r[2], scene.width);
    const double bottom = pixel(r[1] + r[3], scene.height);
    r[0] = pixel(r[0], scene.width);
    r[1] = pixel(r[1], scene.height);
    r[2] = right - r[0];
    r[3] = bottom - r[1];
  }
  if (r[0] < 0 || r[1] < 0 || r[2] < 1 || r[3] < 1 || r[0] + r[2] > scene.width ||
      r[1] + r[3] > scene.height) {
    table.fail(
        "rectangle",
        fmt::format("x {:g}, y {:g}, width {:g}, height {:g} (pixels) is empty or not inside "
                    "the frame of {}x{}",
                    r[0], r[1], r[2], r[3], scene.width, scene.height));
  }
  return {int(r[0]), int(r[1]), int(r[2]), int(r[3])};
}

/// What reading a figure needs of the rest of the experiment.
struct FigureContext {
  const SceneSettings& scene;
  const Methods& methods;
  const std::vector<PlannedCell>& cells;
  bool budget;
};

/// The parameters that select one cell of each of the figure's methods; they do.
NamedValues read_selection(TomlTable& table, const FigureSettings& figure,
                           const FigureContext& context) {
  const auto known = known_methods(table, "methods", figure.methods, context.methods);
  NamedValues select = single_values(read_parameters(table, known, {}));
  for (const std::string& method : figure.methods) {
    try {
      const int group = select_group(context.cells, method, select);
      const auto cell = std::ranges::find(context.cells, group, &PlannedCell::group);
      if (figure.kind != FigureKind::comparison && figure.kind != FigureKind::closeups &&
          cell->role == Role::reference) {
        table.fail("methods", fmt::format("'{}' is the reference itself", method));
      }
      if ((figure.kind == FigureKind::error_budget || figure.kind == FigureKind::failure_classes) &&
          !has_budget(*cell)) {
        table.fail("methods", fmt::format("'{}' has no budget: it does not march through the depth "
                                          "buffer, or has no form on the CPU",
                                          method));
      }
    } catch (const SelectionError& error) {
      table.fail(select.empty() ? "methods" : select.front().first, error.what());
    }
  }
  return select;
}

FigureSettings read_figure(TomlTable& table, const FigureContext& context) {
  FigureSettings figure;
  figure.name = table.identifier("name");
  const std::vector<std::pair<std::string, FigureKind>> kinds = {
      {"comparison", FigureKind::comparison},
      {"closeups", FigureKind::closeups},
      {"error_map", FigureKind::error_map},
      {"error_budget", FigureKind::error_budget},
      {"failure_classes", FigureKind::failure_classes}};
  std::vector<std::string> words;
  for (const auto& [word, unused] : kinds) words.push_back(word);
  const std::string kind = table.one_of("kind", words, "");
  figure.kind = std::ranges::find(kinds, kind, &std::pair<std::string, FigureKind>::first)->second;
  figure.title = table.text("title", "");
  figure.stage = table.one_of("stage", {"filtered", "unfiltered"}, "filtered");
  figure.methods = table.words("methods");
  known_methods(table, "methods", figure.methods, context.methods);
  if (figure.kind == FigureKind::closeups) {
    for (TomlTable& row_table : table.tables("rows")) {
      CloseupRow row;
      row.label = row_table.text("label");
      row.rectangle = read_rectangle(row_table, context.scene);
      row.select = read_selection(row_table, figure, context);
      figure.rows.push_back(std::move(row));
    }
    table.refuse_others();
    return figure;
  }
  if (figure.kind != FigureKind::comparison) {
    figure.scale = table.real("scale", 1e-9, 1e9, std::nullopt);
    if (context.cells.front().role != Role::reference) {
      table.fail("kind", "a figure of errors needs a [reference]");
    }
  }
  const bool of_budget =
      figure.kind == FigureKind::error_budget || figure.kind == FigureKind::failure_classes;
  if (of_budget && !context.budget) table.fail("kind", fmt::format("'{}' needs a [budget]", kind));
  if (figure.kind == FigureKind::failure_classes && figure.methods.size() != 1) {
    table.fail("methods", "accepted is one method: all that share its march have the same classes");
  }
  figure.select = read_selection(table, figure, context);
  return figure;
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
  std::vector<TomlTable> run_tables = root.tables("run");
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
