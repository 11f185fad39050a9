#include "harness/report/data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "harness/csv.h"
#include "harness/experiment_tables.h"
#include "harness/figures/colour_maps.h"
#include "harness/files.h"
#include "harness/measurement_facts.h"
#include "harness/metrics/metrics.h"
#include "harness/published.h"
#include "harness/results_folder.h"
#include "harness/table_formats.h"
#include "renderers/methods/method.h"
#include "renderers/scene/error.h"
#include "renderers/scene/limited_json.h"

namespace occlab::report {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr int run_schema = 1;

TimingTableSettings timing_settings(const json& run) {
  if (!run.is_object() || !run.contains("timing_table")) return {};
  return stored_timing_table_settings(run["timing_table"]);
}

json texts_json(const NamedTexts& texts) {
  json object = json::object();
  for (const auto& [name, value] : texts) object[name] = value;
  return object;
}

/// JSON has no infinity.
json number_json(double value) {
  return std::isfinite(value) ? json(value) : json(number_text(value));
}

json cell_json(const Cell& cell) {
  const std::string* seed = find_text(cell.parameters, "seed");
  return {{"id", cell.id}, {"seed", seed ? *seed : ""}, {"problem", cell.problem}};
}

std::string hex_colour(const DisplayColour& colour) {
  std::string text = "#";
  for (const float channel : colour) text += fmt::format("{:02x}", std::lround(255.0f * channel));
  return text;
}

/// Ratios and differences of two methods are for the tables.
bool is_plotted(const Measurement& row) {
  return row.seed == "all" && !compared_metric(row.metric);
}

json row_json(const Measurement& row, std::size_t group) {
  json entry = {{"group", group}, {"view", row.view}, {"metric", row.metric}, {"n", row.n}};
  if (!row.stage.empty()) entry["stage"] = row.stage;
  if (!row.unit.empty()) entry["unit"] = row.unit;
  if (row.value) entry["value"] = number_json(*row.value);
  if (row.lower) entry["lower"] = number_json(*row.lower);
  if (row.upper) entry["upper"] = number_json(*row.upper);
  if (!row.reason.empty()) entry["reason"] = row.reason;
  if (!row.clock.empty()) entry["clock"] = row.clock;
  return entry;
}

}  // namespace

json read_any_run(const fs::path& results) {
  const fs::path path = results / "run.json";
  std::error_code error;
  if (!fs::exists(path, error)) {
    if (fs::is_directory(results / "cells", error)) return nullptr;
    throw InputError(
        fmt::format("{}: neither run.json nor cells are there: not a results folder; 'occlab run "
                    "CONFIG --out DIR' makes one",
                    results.string()));
  }
  json run = parse_limited_json_or_discard(read_text(path));
  if (!run.is_object() || !run.contains("schema")) {
    throw InputError(
        fmt::format("{}: key 'schema': missing; was it written by 'occlab run'?", path.string()));
  }
  if (run["schema"] != json(run_schema) && !is_of_several_benches(run)) {
    throw InputError(
        fmt::format("{}: key 'schema': {} is unknown; accepted: {}. It was written by occlab {}: "
                    "report it with that version, or run the experiment again with this one",
                    path.string(), run["schema"].dump(), run_schema,
                    run.value("commit", json("of an unknown version")).dump()));
  }
  return run;
}

bool is_of_several_benches(const json& run) {
  return run.is_object() && run.value("schema", json()) == json(schema_of_several_benches);
}

json read_run(const fs::path& results) {
  json run = read_any_run(results);
  if (!is_of_several_benches(run)) return run;
  throw InputError(fmt::format(
      "{}: key 'benches': {} scenes, views, resolutions and probes; a report is of one of them: "
      "run it on its own with --set. 'occlab table' and 'occlab query' read all",
      (results / "run.json").string(), run.value("benches", json::array()).size()));
}

std::vector<Measurement> read_rows(const fs::path& results, const json& run, Verdict& verdict) {
  const fs::path path = results / "measurements.csv";
  std::error_code error;
  if (!fs::exists(path, error)) {
    verdict.incomplete("measurements.csv is missing: the run has not measured yet");
    return {};
  }
  if (run.is_object() && run.value("measurements_sha256", json()) != json(sha256_file(path))) {
    verdict.incomplete(
        "measurements.csv is not the one that run.json describes: it was edited, or a run was "
        "killed between writing the two. The same 'occlab run' writes both again");
  }
  try {
    return read_measurements(path);
  } catch (const InputError& failure) {
    verdict.incomplete(fmt::format("no tables and plots: {}", failure.what()));
    return {};
  }
}

json tables_json(const std::vector<Measurement>& rows, const json& run, Verdict& verdict) {
  if (rows.empty()) return json::array();
  try {
    return json::parse(format_tables(make_tables(rows, timing_settings(run)), "json"));
  } catch (const InputError& failure) {
    verdict.incomplete(fmt::format("no tables: {}", failure.what()));
    return json::array();
  }
}

json plots_json(const std::vector<Measurement>& rows) {
  std::map<std::pair<std::string, NamedTexts>, std::size_t> known;
  json groups = json::array();
  json plotted = json::array();
  for (const Measurement& row : rows) {
    if (!is_plotted(row)) continue;
    const auto [place, is_new] = known.try_emplace({row.method, row.parameters}, groups.size());
    if (is_new) {
      groups.push_back({{"method", row.method},
                        {"parameters", texts_json(row.parameters)},
                        {"resolution", row.resolution},
                        {"scene", row.scene}});
    }
    plotted.push_back(row_json(row, place->second));
  }
  return {{"groups", groups}, {"rows", plotted}};
}

json published_json(const json& run, Verdict& verdict) {
  const std::string name = timing_settings(run).published;
  if (name.empty()) return nullptr;
  try {
    const PublishedTimes published = read_published_times(published_path(name));
    json times = json::array();
    for (const PublishedTime& time : published.times) {
      times.push_back({{"method", time.method},
                       {"device", time.device},
                       {"samples", std::to_string(time.samples)},
                       {"steps", std::to_string(time.steps)},
                       {"time_ms", time.time_ms},
                       {"resolution", fmt::format("{}x{}", time.width, time.height)},
                       {"origin", time.origin}});
    }
    return {{"source", published.source}, {"times", times}};
  } catch (const InputError& failure) {
    verdict.problems.push_back(fmt::format("no published times: {}", failure.what()));
    return nullptr;
  }
}

json groups_json(const std::vector<Cell>& cells, const std::vector<Group>& groups) {
  json list = json::array();
  for (const Group& group : groups) {
    json members = json::array();
    for (const std::size_t index : group.cells) members.push_back(cell_json(cells[index]));
    list.push_back({{"method", group.method},
                    {"parameters", texts_json(group.parameters)},
                    {"reference", group.reference},
                    {"truth", group.truth},
                    {"cells", members}});
  }
  return list;
}

json other_cells_json(const std::vector<Cell>& cells, const std::vector<Group>& groups) {
  std::vector<bool> grouped(cells.size(), false);
  for (const Group& group : groups) {
    for (const std::size_t index : group.cells) grouped[index] = true;
  }
  json list = json::array();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (grouped[i]) continue;
    json entry = cell_json(cells[i]);
    entry["method"] = cells[i].method;
    entry["parameters"] = texts_json(cells[i].parameters);
    list.push_back(std::move(entry));
  }
  return list;
}

json layers_json(const PackedImages& images) {
  json list = json::array();
  for (const PackedLayer& layer : images.layers) {
    list.push_back({{"id", layer.id},
                    {"owner", layer.owner},
                    {"name", layer.name},
                    {"kind", layer.kind},
                    {"cell", layer.cell},
                    {"width", layer.width},
                    {"height", layer.height},
                    {"channels", layer.channels},
                    {"step", layer.step},
                    {"note", layer.note},
                    {"bytes", layer.bytes},
                    {"preview", layer.preview}});
  }
  return list;
}

json methods_json(const std::vector<Group>& groups, const json& figures) {
  std::vector<std::vector<std::string>> names;
  for (const json& figure : figures) names.push_back(figure["methods"]);
  names.emplace_back();
  for (const Group& group : groups) names.back().push_back(group.method);
  json object = json::object();
  for (const auto& [name, colour] : frame_colours(names)) {
    const auto known = std::ranges::find(methods(), name, &MethodInfo::name);
    object[name] = {{"title", known == methods().end() ? name : known->title},
                    {"colour", hex_colour(colour)}};
  }
  return object;
}

json metrics_json() {
  json list = json::array();
  for (const MetricInfo& metric : metrics()) {
    list.push_back({{"name", metric.name},
                    {"unit", metric.unit == "1" ? "" : metric.unit},
                    {"definition", metric.definition},
                    {"lowerIsBetter", metric.lower_is_better}});
  }
  return list;
}

json colour_maps_json() {
  constexpr int count = 257;  // odd: one of them is 0 of the signed map
  const auto sample = [](ErrorMap kind) {
    json colours = json::array();
    for (int i = 0; i < count; ++i) {
      const double start = error_scale_start(kind, 1.0);
      colours.push_back(
          hex_colour(error_colour(kind, start + (1.0 - start) * i / (count - 1), 1.0)));
    }
    return colours;
  };
  return {{"signed", sample(ErrorMap::signed_luminance)}, {"positive", sample(ErrorMap::rms)}};
}

}  // namespace occlab::report
