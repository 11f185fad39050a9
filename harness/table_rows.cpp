#include "harness/table_rows.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <unordered_map>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

/// The facts that differ become columns, the others one note.
struct Labels {
  std::vector<std::string> columns;
  std::string note;
};

Labels make_labels(const std::vector<Facts>& rows) {
  std::vector<std::string> names;
  for (const Facts& facts : rows) merge_names(names, facts);
  Labels labels;
  std::vector<std::string> same;
  for (const std::string& name : names) {
    std::set<std::string> values;
    for (const Facts& facts : rows) values.insert(fact(facts, name));
    values.erase("");
    if (name == "method" || values.size() > 1) {
      labels.columns.push_back(name);
    } else {
      same.push_back(fmt::format("{} = {}", name, *values.begin()));
    }
  }
  if (!same.empty()) labels.note = fmt::format("All rows that have it: {}", fmt::join(same, ", "));
  return labels;
}

}  // namespace

Rows select_rows(const std::vector<Measurement>& measurements,
                 const std::function<bool(const Measurement&)>& wanted) {
  Rows rows;
  for (const Measurement& m : measurements) {
    if (m.seed == "all" && wanted(m)) rows.push_back(&m);
  }
  return rows;
}

const Measurement* RowGroup::find(const std::string& metric) const {
  const auto found = std::ranges::find(measurements, metric, &Measurement::metric);
  return found == measurements.end() ? nullptr : *found;
}

std::vector<RowGroup> group_rows(const Rows& rows) {
  std::vector<RowGroup> groups;
  std::unordered_map<std::string, std::size_t> places;
  for (const Measurement* m : rows) {
    Facts facts = facts_of(*m);
    const auto [place, added] = places.try_emplace(facts_key(facts), groups.size());
    if (added) groups.push_back({std::move(facts), {}});
    RowGroup& group = groups[place->second];
    if (group.find(m->metric)) {
      std::vector<std::string> row;
      for (const auto& [name, value] : group.facts) row.push_back(name + " = " + value);
      throw InputError(
          fmt::format("measurements: '{}' is there twice for {}", m->metric, fmt::join(row, ", ")));
    }
    group.measurements.push_back(m);
  }
  return groups;
}

Table start_table(const std::vector<Facts>& rows, std::string name, std::string title) {
  const Labels labels = make_labels(rows);
  Table table{std::move(name), std::move(title), {}, {}, {}};
  for (const std::string& label : labels.columns) {
    const bool text = label == "method" || label == "probe" || label == "scene" || label == "view";
    table.columns.push_back({label, "", text ? Alignment::left : Alignment::right});
  }
  for (const Facts& row : rows) {
    table.rows.emplace_back();
    for (const std::string& label : labels.columns)
      table.rows.back().emplace_back(fact(row, label));
  }
  if (!labels.note.empty()) table.notes.push_back(labels.note);
  return table;
}

Table start_table(const std::vector<RowGroup>& groups, std::string name, std::string title) {
  std::vector<Facts> rows;
  for (const RowGroup& group : groups) rows.push_back(group.facts);
  return start_table(rows, std::move(name), std::move(title));
}

void add_column(Table& table, TableColumn column,
                const std::function<TableCell(std::size_t row)>& cell) {
  table.columns.push_back(std::move(column));
  for (std::size_t i = 0; i < table.rows.size(); ++i) table.rows[i].push_back(cell(i));
}

std::vector<std::pair<std::string, std::string>> metrics_with_units(const Rows& rows) {
  std::vector<std::pair<std::string, std::string>> metrics;
  for (const Measurement* m : rows) {
    const auto found = std::ranges::find(metrics, m->metric, [](const auto& p) { return p.first; });
    if (found == metrics.end()) {
      metrics.emplace_back(m->metric, m->unit);
    } else if (found->second != m->unit) {
      throw InputError(fmt::format("measurements: '{}' has the units '{}' and '{}'", m->metric,
                                   found->second, m->unit));
    }
  }
  return metrics;
}

TableCell number_cell(const Measurement* measurement) {
  if (!measurement) return TableMissing{"not measured"};
  if (!measurement->value) return TableMissing{measurement->reason};
  return TableNumber{*measurement->value, measurement->lower, measurement->upper};
}

std::string counts(const Rows& rows) {
  const auto [low, high] = std::ranges::minmax_element(rows, {}, &Measurement::n);
  return (*low)->n == (*high)->n ? fmt::format("n = {}", (*low)->n)
                                 : fmt::format("n = {} to {}", (*low)->n, (*high)->n);
}

}  // namespace occlab
