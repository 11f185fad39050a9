#include "harness/budget_tables.h"

#include <fmt/format.h>

#include <array>

#include "harness/table_rows.h"

namespace occlab {
namespace {

constexpr std::array<const char*, 5> parts = {"total", "representation", "visibility", "sampling",
                                              "filter"};

TableCell cell_of(const RowGroup& group, const std::string& metric) {
  const Measurement* measurement = group.find(metric);
  if (!measurement) return TableMissing{"no such part at this stage"};
  return number_cell(measurement);
}

void add_metric(Table& table, const std::vector<RowGroup>& groups, const std::string& title,
                const std::string& unit, const std::string& metric) {
  add_column(table, {title, unit, Alignment::right},
             [&](std::size_t row) { return cell_of(groups[row], metric); });
}

}  // namespace

Table budget_table(const std::vector<Measurement>& measurements, const std::string& stage) {
  const Rows rows = select_rows(measurements, [&](const Measurement& m) {
    return m.stage == stage && is_budget(m) && m.metric.starts_with("budget_");
  });
  const std::vector<RowGroup> groups = group_rows(rows);
  Table table = start_table(groups, "error_budget_" + stage, "Error budget, " + stage);
  if (rows.empty()) return table;
  for (const std::string part : parts) {
    if (part == "filter" && stage == "unfiltered") continue;
    add_metric(table, groups, part, "mean luminance", "budget_rms." + part);
    if (part != "total") add_metric(table, groups, part + " share", "", "budget_share." + part);
    add_metric(table, groups, part + " mean", "mean luminance", "budget_mean." + part);
  }
  add_metric(table, groups, "floor", "mean luminance", "budget_floor");
  table.notes = {
      "total = method - reference; representation = converged with traced visibility - reference; "
      "visibility = converged with its own march - converged with traced visibility; sampling = "
      "before the filter - converged with its own march; filter = after - before the filter",
      "Without a name: RMS over the surface's pixels. Shares of the mean squared error and means "
      "(signed) add up over the parts; a part that works against the rest has a negative share",
      "floor: RMS of the noise that the reference and the converged runs leave in the parts; a "
      "part near it is not told from 0"};
  return table;
}

Table failure_table(const std::vector<Measurement>& measurements) {
  // A measurement's class is the end of its metric; here it becomes a fact of the row.
  std::vector<Measurement> by_class;
  std::string floor;
  for (const Measurement& m : measurements) {
    if (!is_budget(m) || !m.metric.starts_with("failure_")) continue;
    const std::size_t dot = m.metric.find('.');
    if (dot == std::string::npos) {
      if (m.value) floor = fmt::format("{:.2g}", *m.value);
      continue;
    }
    Measurement row = m;
    row.method = m.metric.substr(dot + 1);
    row.metric = m.metric.substr(0, dot);
    by_class.push_back(std::move(row));
  }
  const Rows rows = select_rows(by_class, [](const Measurement&) { return true; });
  const std::vector<RowGroup> groups = group_rows(rows);
  Table table = start_table(groups, "failure_classes", "Where the depth buffer's visibility fails");
  if (rows.empty()) return table;
  for (TableColumn& column : table.columns) {
    if (column.name == "method") column.name = "class";
  }
  add_metric(table, groups, "pixels", "share", "failure_pixels");
  add_metric(table, groups, "mean", "k_A", "failure_mean");
  add_metric(table, groups, "RMS", "k_A", "failure_rms");
  add_metric(table, groups, "share of the visibility error", "", "failure_share");
  table.notes.insert(
      table.notes.end(),
      {"off_screen, hidden_blocker (behind the first surface of its pixel) and thin (in full view, "
       "missed by the steps): light leaks in; behind_surface (a free ray that passes behind the "
       "first surface) and beyond_radius: light is lost; edge: either, at a silhouette",
       "pixels: whose k_A the class changes by more than .01; share: of the mean squared "
       "visibility error of the radiance, as SSDO looks it up, summing to 1",
       "The sum over the classes has a standard error of " + floor +
           " (RMS over the pixels, k_A)"});
  return table;
}

}  // namespace occlab
