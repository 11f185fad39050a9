#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "harness/config.h"
#include "harness/tables.h"
#include "harness/timing_tables.h"

namespace occlab {

/// What the tables of times need: of the experiment, and the notes of the timing's context
/// (TimingResult), if there is one.
TimingTableSettings timing_table_settings(const Experiment& experiment,
                                          const nlohmann::json& timing_context = {});

/// As run.json keeps it in `timing_table`, and back.
nlohmann::json to_json(const TimingTableSettings& settings);
TimingTableSettings stored_timing_table_settings(const nlohmann::json& stored);

/// The tables of a results folder, in reading order: times beside the published ones and
/// how they grow; noise and
/// accuracy of both stages; accuracy in the closeups; the comparisons behind the marks of the
/// winners; orderings. Those without a row are left out. The closeups' comparisons are not printed:
/// their ratios are among the orderings.
std::vector<Table> make_tables(const std::vector<Measurement>& measurements,
                               const TimingTableSettings& timing);

/// Those of the times alone.
std::vector<Table> make_timing_tables(const std::vector<Measurement>& measurements,
                                      const TimingTableSettings& timing);

/// Every table in every format, as FOLDER/NAME.md and so on.
void write_tables(const std::vector<Table>& tables, const std::filesystem::path& folder);

/// All tables in one format, as one text; "json" is one array with an object for each.
std::string format_tables(const std::vector<Table>& tables, const std::string& format);

}  // namespace occlab
