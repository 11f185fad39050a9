// plan and select_group of config.h.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>

#include "harness/plan_parts.h"

namespace occlab {

const MethodInfo& planned_method(const std::vector<MethodInfo>& methods, const std::string& name) {
  const auto method = std::ranges::find(methods, name, &MethodInfo::name);
  assert(method != methods.end());
  return *method;
}

ParameterSet common_parameters(const Experiment& experiment, const MethodInfo& method) {
  ParameterSet parameters(method.parameters);
  for (const auto& [name, value] : experiment.parameters) {
    if (parameters.has(name)) parameters.set(name, value);
  }
  return parameters;
}

namespace {

/// "samples (32, 16, 8)": the values the cells have for a parameter.
std::string found_values(const std::vector<const PlannedCell*>& cells, const std::string& name) {
  std::vector<std::string> values;
  for (const PlannedCell* cell : cells) {
    const std::string value = to_string(cell->parameters.value(name));
    if (std::ranges::find(values, value) == values.end()) values.push_back(value);
  }
  return fmt::format("{} ({})", name, fmt::join(values, ", "));
}

bool is_excluded_of(const std::string& method, NamedValues point, const Grid& grid) {
  point.emplace_back("method", method);
  return is_excluded(point, grid);
}

bool matches(const PlannedCell& cell, const NamedValues& select) {
  return std::ranges::all_of(select, [&](const auto& wanted) {
    const auto& [name, value] = wanted;
    if (!cell.parameters.has(name)) return true;
    // set() gives the wanted value the declared kind, so that 1 matches 1.0.
    ParameterSet probe = cell.parameters;
    probe.set(name, value);
    return probe.value(name) == cell.parameters.value(name);
  });
}

}  // namespace

std::vector<PlannedCell> plan(const Experiment& experiment,
                              const std::vector<MethodInfo>& methods) {
  std::vector<PlannedCell> cells;
  int group = 0;
  if (experiment.reference) {
    const ReferenceSettings& reference = *experiment.reference;
    const auto add = [&](const std::string& of, std::optional<long> rays) {
      const MethodInfo& method = planned_method(methods, of);
      ParameterSet parameters = common_parameters(experiment, method);
      for (const auto& [name, value] : reference.parameters) parameters.set(name, value);
      if (rays) parameters.set("rays_per_pixel", *rays);
      cells.push_back({Role::reference, method.name, std::move(parameters), group++, method.truth});
    };
    add(reference.method, std::nullopt);
    // Only the first is traced step by step until it is certified.
    for (const std::string& other : reference.others) add(other, reference.max_rays_per_pixel);
  }
  for (const RunSettings& run : experiment.runs) {
    for (const std::string& name : run.methods) {
      const MethodInfo& method = planned_method(methods, name);
      for (const NamedValues& point : cross(run.grid)) {
        if (!run.grid.exclusions.empty() && is_excluded_of(name, point, run.grid)) continue;
        ParameterSet parameters = common_parameters(experiment, method);
        for (const auto& [parameter, value] : point) parameters.set(parameter, value);
        for (const long seed : run.seeds) {
          if (parameters.has("seed")) parameters.set("seed", seed);
          cells.push_back({Role::test, name, parameters, group, method.truth});
        }
        ++group;
      }
    }
  }
  return cells;
}

std::size_t reference_place(const std::vector<PlannedCell>& cells, const PlannedCell& test) {
  for (std::size_t i = 0; i < cells.size() && cells[i].role == Role::reference; ++i) {
    if (cells[i].method == test.truth) return i;
  }
  return 0;
}

int select_group(const std::vector<PlannedCell>& cells, const std::string& method,
                 const NamedValues& select) {
  std::vector<const PlannedCell*> of_method;
  std::vector<const PlannedCell*> selected;
  std::vector<int> groups;
  for (const PlannedCell& cell : cells) {
    if (cell.method != method) continue;
    of_method.push_back(&cell);
    if (!matches(cell, select)) continue;
    selected.push_back(&cell);
    if (std::ranges::find(groups, cell.group) == groups.end()) groups.push_back(cell.group);
  }
  if (groups.size() == 1) return groups.front();
  if (of_method.empty()) {
    throw SelectionError(fmt::format("no [[run]] and no [reference] makes a cell of '{}'", method));
  }

  // Say what there is: the selected parameters where nothing matches, the differing ones where too
  // much does.
  std::vector<std::string> found;
  for (const Parameter& parameter : of_method.front()->parameters.declared()) {
    const auto value = [&](const PlannedCell* cell) {
      return to_string(cell->parameters.value(parameter.name));
    };
    const bool named = std::ranges::any_of(
        select, [&](const auto& wanted) { return wanted.first == parameter.name; });
    const bool differs = std::ranges::any_of(
        selected, [&](const PlannedCell* cell) { return value(cell) != value(selected.front()); });
    if (groups.empty() ? named : differs && parameter.name != "seed") {
      found.push_back(found_values(groups.empty() ? of_method : selected, parameter.name));
    }
  }
  throw SelectionError(
      groups.empty()
          ? fmt::format("no cell of '{}' has these values; there are {}", method,
                        fmt::join(found, ", "))
          : fmt::format("{} groups of cells of '{}' match, which differ in {}; say which",
                        groups.size(), method, fmt::join(found, ", ")));
}

}  // namespace occlab
