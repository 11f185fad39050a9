// read_timing of config_parts.h.

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "harness/config_parts.h"
#include "harness/published.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

std::vector<Resolution> read_resolutions(TomlTable& table) {
  std::vector<Resolution> sizes;
  for (const std::string& text : table.words(resolution_axis)) {
    const std::optional<Resolution> size = parse_resolution(text);
    if (!size) {
      table.fail(resolution_axis,
                 fmt::format("found '{}'; accepted is a width and a height from {} to {}, such as "
                             "'1280x720'",
                             text, shortest_side, longest_side));
    }
    if (std::ranges::find(sizes, *size) != sizes.end()) {
      table.fail(resolution_axis, fmt::format("{} is listed twice", text));
    }
    sizes.push_back(*size);
  }
  return sizes;
}

std::vector<long> read_counts(TomlTable& table, const char* name, long most) {
  std::vector<long> counts;
  for (const ParameterValue& value : table.values(name, true)) {
    const long* const count = std::get_if<long>(&value);
    if (!count || *count < 1 || *count > most) {
      table.fail(name,
                 fmt::format("found {}; accepted are integers in [1, {}]", to_string(value), most));
    }
    counts.push_back(*count);
  }
  return counts;
}

/// What ratios are to, of the axes: each one of the axis's values.
NamedValues read_baseline_values(TomlTable table, const std::vector<const MethodInfo*>& methods,
                                 const std::vector<Axis>& axes) {
  const NamedValues values =
      single_values(read_parameters(table, methods, {.lists = false, .by_all = true}));
  for (const auto& [name, value] : values) {
    const auto axis = std::ranges::find(axes, name, &Axis::parameter);
    if (axis == axes.end() || std::ranges::find(axis->values, value) == axis->values.end()) {
      table.fail(name, fmt::format("found {}; accepted are axes of [timing] and their values",
                                   to_string(value)));
    }
  }
  return values;
}

}  // namespace

TimingSettings read_timing(TomlTable table, const std::vector<MethodInfo>& methods) {
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
  timing.note = table.text("note", "");
  timing.one_by_one = table.one_of("axes", {"crossed", "one_by_one"}, "crossed") == "one_by_one";
  if (table.has(resolution_axis)) timing.resolutions = read_resolutions(table);
  if (table.has(triangles_axis)) timing.triangles = read_counts(table, triangles_axis, 1L << 26);
  if (table.has(threads_axis))
    timing.threads = read_counts(table, threads_axis, most_rasteriser_threads);
  std::optional<TomlTable> baseline_at;
  if (table.has("baseline_at")) baseline_at.emplace(table.table("baseline_at"));
  timing.axes = read_parameters(table, known, {.lists = true, .by_all = true});
  if (baseline_at) {
    if (timing.one_by_one) table.fail("baseline_at", "accepted with crossed axes only");
    timing.baseline_at = read_baseline_values(*baseline_at, known, timing.axes);
  }
  if (timing.one_by_one && timing.axes.empty() && timing.resolutions.empty() &&
      timing.triangles.empty() && timing.threads.empty()) {
    table.fail("axes", "'one_by_one' needs an axis: resolution, triangles, threads or a parameter");
  }
  return timing;
}

}  // namespace occlab
