// What config_parts.h has of axes: zips, exclusions and [[run]].

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>

#include "harness/config_parts.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr const char* method_axis = "method";

const Axis* find_axis(const Grid& grid, const std::string& name) {
  const auto axis = std::ranges::find(grid.axes, name, &Axis::parameter);
  return axis == grid.axes.end() ? nullptr : &*axis;
}

std::vector<std::string> axis_names(const Grid& grid) {
  std::vector<std::string> names;
  for (const Axis& axis : grid.axes) names.push_back(axis.parameter);
  return names;
}

std::string values_text(const Axis& axis) {
  std::vector<std::string> texts;
  for (const ParameterValue& value : axis.values) texts.push_back(to_string(value));
  return fmt::format("{}", fmt::join(texts, ", "));
}

/// An exclusion's key, as errors of its table have it: "scene.view" is not a key of its own.
std::string own_key(const std::string& name) { return name.substr(0, name.find('.')); }

/// Every point with every method; without methods, the points.
std::vector<NamedValues> with_methods(const Grid& grid, const std::vector<std::string>& methods) {
  Grid all = grid;
  if (!methods.empty()) {
    Axis axis{method_axis, {}};
    for (const std::string& method : methods) axis.values.emplace_back(method);
    all.axes.push_back(std::move(axis));
  }
  return cross(all);
}

Grid read_grid(TomlTable& table, const std::vector<const MethodInfo*>& known,
               const std::vector<std::string>& names) {
  Grid grid;
  grid.zips = table.word_lists("zip");
  std::vector<TomlTable> exclusions;
  if (table.has("exclude")) exclusions = table.tables("exclude");
  grid.axes = read_parameters(table, known, {.lists = true, .by_all = true, .zips = grid.zips});
  check_zips(table, grid);
  const long methods = std::ssize(names);
  long cells = count_crossed(grid);
  if (__builtin_mul_overflow(cells, methods, &cells)) cells = std::numeric_limits<long>::max();
  check_count(table, "methods", cells, "the run's axes and methods");
  for (TomlTable& entry : exclusions) {
    std::vector<Axis> exclusion;
    for (const std::string& name : entry.others()) {
      Axis axis{name, entry.values(name, true)};
      // Words such as gbuffer_bits' 16 may be written as numbers.
      const Axis* const varied = find_axis(grid, name);
      if (varied && std::holds_alternative<std::string>(varied->values.front())) {
        for (ParameterValue& value : axis.values) value = to_string(value);
      }
      exclusion.push_back(std::move(axis));
    }
    grid.exclusions.push_back(std::move(exclusion));
  }
  check_exclusions(exclusions, grid, names);
  return grid;
}

std::vector<long> read_seeds(TomlTable& table) {
  constexpr long most_seeds = 4096;
  if (!table.is_list("seeds")) {
    std::vector<long> seeds(std::size_t(table.integer("seeds", 1, most_seeds, 1)));
    for (std::size_t i = 0; i < seeds.size(); ++i) seeds[i] = long(i);
    return seeds;
  }
  std::vector<long> seeds;
  for (const ParameterValue& value : table.values("seeds", true)) {
    const long* const seed = std::get_if<long>(&value);
    if (!seed || *seed < 0 || *seed > 1'000'000'000) {
      table.fail("seeds", fmt::format("found {}; accepted are integers in [0, 1000000000]",
                                      to_string(value)));
    }
    seeds.push_back(*seed);
  }
  if (std::ssize(seeds) > most_seeds) {
    table.fail("seeds",
               fmt::format("found {} of them; accepted are at most {}", seeds.size(), most_seeds));
  }
  return seeds;
}

}  // namespace

void check_zips(const TomlTable& table, const Grid& grid) {
  for (const std::vector<std::string>& zip : grid.zips) {
    const Axis* first = nullptr;
    for (const std::string& name : zip) {
      const Axis* const axis = find_axis(grid, name);
      if (!axis) {
        table.fail("zip", fmt::format("'{}' is no axis here{}", name,
                                      accepted_words(name, axis_names(grid))));
      }
      if (first && first->values.size() != axis->values.size()) {
        table.fail("zip",
                   fmt::format("'{}' has {} values and '{}' {}; accepted are axes with "
                               "equally many",
                               first->parameter, first->values.size(), name, axis->values.size()));
      }
      if (!first) first = axis;
    }
  }
}

void check_exclusions(const std::vector<TomlTable>& tables, const Grid& grid,
                      const std::vector<std::string>& methods) {
  if (tables.empty()) return;
  const std::vector<NamedValues> all = with_methods(grid, methods);
  std::vector<std::string> names = axis_names(grid);
  if (!methods.empty()) names.emplace_back(method_axis);
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const std::vector<Axis>& exclusion = grid.exclusions[i];
    if (exclusion.empty()) tables[i].fail("", "names no axis; it would exclude everything");
    for (const Axis& axis : exclusion) {
      if (std::ranges::find(names, axis.parameter) == names.end()) {
        tables[i].fail(own_key(axis.parameter),
                       fmt::format("'{}' is no axis here{}", axis.parameter,
                                   accepted_words(axis.parameter, names)));
      }
      for (const ParameterValue& value : axis.values) {
        const std::vector<Axis> one = {{axis.parameter, {value}}};
        const auto taken = [&](const NamedValues& point) { return has_values(point, one); };
        if (std::ranges::none_of(all, taken)) {
          const Axis* const varied = find_axis(grid, axis.parameter);
          tables[i].fail(
              own_key(axis.parameter),
              fmt::format(
                  "'{}' is never {}; accepted: {}", axis.parameter, to_string(value),
                  varied ? values_text(*varied) : fmt::format("{}", fmt::join(methods, ", "))));
        }
      }
    }
    if (std::ranges::none_of(all,
                             [&](const auto& point) { return has_values(point, exclusion); })) {
      tables[i].fail("", "excludes nothing: no point of the axes has all of these values");
    }
  }
  if (std::ranges::all_of(all, [&](const auto& point) { return is_excluded(point, grid); })) {
    tables.back().fail("", "with this exclusion nothing is left");
  }
}

void check_count(const TomlTable& table, const std::string& key, long cells,
                 const std::string& what) {
  if (cells <= most_cells) return;
  table.fail(key, fmt::format("{} make {} cells; accepted are at most {}", what,
                              cells == std::numeric_limits<long>::max() ? "more than 2^63"
                                                                        : fmt::format("{}", cells),
                              most_cells));
}

RunSettings read_run(TomlTable& table, const std::vector<MethodInfo>& methods) {
  RunSettings run;
  run.methods = table.words("methods");
  const auto known = known_methods(table, "methods", run.methods, methods);
  run.seeds = read_seeds(table);
  run.grid = read_grid(table, known, run.methods);
  // The grid's own count is checked before it is crossed; this is at most 4096 times that.
  check_count(table, "seeds",
              count_crossed(run.grid) * std::ssize(run.methods) * std::ssize(run.seeds),
              "the run's axes, methods and seeds");
  for (const MethodInfo* method : known) {
    if (run.seeds != std::vector<long>{0} && !declares(*method, "seed")) {
      table.fail("seeds", fmt::format("method '{}' has no seed; accepted is 1", method->name));
    }
  }
  return run;
}

}  // namespace occlab
