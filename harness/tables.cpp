#include "harness/tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "harness/table_rows.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

/// What a mark means, or why there is none.
std::string winner_note(const Comparisons& comparisons) {
  if (comparisons.tested == 0) return "No winner is marked: nothing could be compared over seeds";
  const double first_level = comparisons.level / double(comparisons.tested);
  if (comparisons.smallest_p > first_level) {
    return fmt::format(
        "No winner is marked: these seeds give no p-value below {:.2g}, and of {} comparisons one "
        "would have to be below {:.2g}",
        comparisons.smallest_p, comparisons.tested, first_level);
  }
  return fmt::format(
      "Bold (in CSV and JSON: winner): better than every other method under the same conditions, "
      "seed by seed; that any verdict of the {} comparisons behind this table is wrong has a "
      "probability of at most {:g}% (Holm's correction)",
      comparisons.tested, 100.0 * comparisons.level);
}

/// One column for each metric there is.
Table metric_table(const Rows& rows, std::string name, std::string title,
                   const Comparisons& comparisons) {
  const std::vector<RowGroup> groups = group_rows(rows);
  const Winners winners(comparisons);
  Table table = start_table(groups, std::move(name), std::move(title));
  for (const auto& [metric, unit] : metrics_with_units(rows)) {
    add_column(table, {metric, unit, Alignment::right}, [&, &wanted = metric](std::size_t row) {
      TableCell cell = number_cell(groups[row].find(wanted));
      if (auto* number = std::get_if<TableNumber>(&cell)) {
        number->winner = winners.wins(facts_key(groups[row].facts), wanted);
      }
      return cell;
    });
  }
  if (rows.empty()) return table;
  table.notes.push_back(fmt::format(
      "Over the seeds, with 95% intervals in brackets where there are several seeds; {}",
      counts(rows)));
  if (!comparisons.all.empty()) table.notes.push_back(winner_note(comparisons));
  return table;
}

}  // namespace

Table accuracy_table(const std::vector<Measurement>& measurements, const std::string& stage,
                     const Comparisons& comparisons) {
  const Rows rows = select_rows(
      measurements, [&](const Measurement& m) { return m.stage == stage && is_accuracy(m); });
  return metric_table(rows, "accuracy_" + stage, fmt::format("Accuracy, {}", stage), comparisons);
}

Table noise_table(const std::vector<Measurement>& measurements, const std::string& stage,
                  const Comparisons& comparisons) {
  const Rows rows = select_rows(
      measurements, [&](const Measurement& m) { return m.stage == stage && is_over_seeds(m); });
  Table table =
      metric_table(rows, "noise_" + stage, fmt::format("Noise and bias, {}", stage), comparisons);
  if (comparisons.tested > 0) {
    table.notes.emplace_back(
        "Noise is compared as a ratio, bias by the difference of the squares, with jackknife "
        "intervals: simulated for 8 seeds, those of nominal 95% cover 93% to 95% for the noise, "
        "and "
        "for the bias down to 83% where an error is alike in all pixels");
  }
  return table;
}

Table brightness_table(const std::vector<Measurement>& measurements, const std::string& stage) {
  const Rows rows = select_rows(
      measurements, [&](const Measurement& m) { return m.stage == stage && is_brightness(m); });
  return metric_table(rows, "brightness_" + stage,
                      fmt::format("Brightness in closeups and at points, {}", stage), {});
}

}  // namespace occlab
