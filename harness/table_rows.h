#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "harness/measurement_facts.h"
#include "harness/tables.h"

namespace occlab {

// What the tables are built of.

using Rows = std::vector<const Measurement*>;

/// The rows over all seeds that are wanted.
Rows select_rows(const std::vector<Measurement>& measurements,
                 const std::function<bool(const Measurement&)>& wanted);

/// A row of a table under construction: its facts and the measurements that share them.
struct RowGroup {
  Facts facts;
  Rows measurements;

  /// nullptr if there is none.
  const Measurement* find(const std::string& metric) const;
};

/// Groups in order of appearance; one value for each metric of a group, InputError otherwise.
std::vector<RowGroup> group_rows(const Rows& rows);

/// A table with one row of labels for each of the facts: those that differ become columns, the
/// others one note.
Table start_table(const std::vector<Facts>& rows, std::string name, std::string title);
Table start_table(const std::vector<RowGroup>& groups, std::string name, std::string title);

/// One column, with the cell that `cell` makes of each row's index.
void add_column(Table& table, TableColumn column,
                const std::function<TableCell(std::size_t row)>& cell);

/// Metrics and their units in order of appearance; InputError where a metric has two.
std::vector<std::pair<std::string, std::string>> metrics_with_units(const Rows& rows);

TableCell number_cell(const Measurement* measurement);

/// "n = 8", or "n = 1 to 8".
std::string counts(const Rows& rows);

}  // namespace occlab
