#pragma once

#include <filesystem>
#include <vector>

#include "harness/config.h"
#include "harness/tables.h"

namespace occlab {

/// What the timing table needs besides the measurements; run.json keeps it.
struct TimingTableSettings {
  std::string baseline;   ///< the method that ratios are to; empty: no times
  std::string published;  ///< results/published/NAME.csv; empty: none
};
TimingTableSettings timing_table_settings(const Experiment& experiment);

/// The tables of a results folder, in reading order: times beside the published ones; noise and
/// accuracy of both stages; accuracy in the closeups; the comparisons behind the marks of the
/// winners; orderings. Those without a row are left out. The closeups' comparisons are not printed:
/// their ratios are among the orderings.
std::vector<Table> make_tables(const std::vector<Measurement>& measurements,
                               const TimingTableSettings& timing);

/// Every table in every format, as FOLDER/NAME.md and so on.
void write_tables(const std::vector<Table>& tables, const std::filesystem::path& folder);

/// All tables in one format, as one text; "json" is one array with an object for each.
std::string format_tables(const std::vector<Table>& tables, const std::string& format);

}  // namespace occlab
