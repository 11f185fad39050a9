#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "harness/measurements.h"
#include "harness/report/cells.h"
#include "harness/report/images.h"

namespace occlab::report {

/// What is wrong with a run as a whole, and whether all of it is there.
struct Verdict {
  bool complete = true;
  std::vector<std::string> problems;

  void incomplete(std::string problem) {
    complete = false;
    problems.push_back(std::move(problem));
  }
};

/// RESULTS/run.json, null where there is none. Throws InputError where it is not one that this
/// occlab reads.
nlohmann::json read_any_run(const std::filesystem::path& results);
/// Whether it is of several scenes, views, resolutions or probes (results_folder.h).
bool is_of_several_benches(const nlohmann::json& run);
/// As read_any_run(), and throws InputError where it is of several.
nlohmann::json read_run(const std::filesystem::path& results);

/// RESULTS/measurements.csv. Where it is missing, damaged or not the one that run.json describes,
/// the verdict says so; of a damaged one there are no rows.
std::vector<Measurement> read_rows(const std::filesystem::path& results, const nlohmann::json& run,
                                   Verdict& verdict);

/// The tables of the measurements, as `occlab table --format json` has them.
nlohmann::json tables_json(const std::vector<Measurement>& rows, const nlohmann::json& run,
                           Verdict& verdict);

/// What the plots draw: {"groups": [{method, parameters}], "rows": [...]}, the rows over all seeds
/// that are of one method.
nlohmann::json plots_json(const std::vector<Measurement>& rows);

/// The published times that run.json names: {source, times}; null if there are none.
nlohmann::json published_json(const nlohmann::json& run, Verdict& verdict);

nlohmann::json groups_json(const std::vector<Cell>& cells, const std::vector<Group>& groups);
/// Cells that are in no group: budgets and parts of the reference.
nlohmann::json other_cells_json(const std::vector<Cell>& cells, const std::vector<Group>& groups);
nlohmann::json layers_json(const PackedImages& images);

/// Titles and colours of the methods by name, coloured as in `figures` (figures_of).
nlohmann::json methods_json(const std::vector<Group>& groups, const nlohmann::json& figures);
/// Every metric's name, unit, definition and direction.
nlohmann::json metrics_json();
/// The figures' colour maps, 257 colours each: {"signed": ["#rrggbb"...], "positive": [...]}.
nlohmann::json colour_maps_json();

}  // namespace occlab::report
