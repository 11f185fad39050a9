#include <fmt/format.h>

#include <algorithm>

#include "harness/table_rows.h"
#include "harness/tables.h"

namespace occlab {
namespace {

using Cell = TableCell (*)(const Comparison&);

/// Rows of the facts of the comparisons; columns of numbers are still to be added.
Table start(const Comparisons& comparisons, std::string name, std::string title, bool with_stage) {
  std::vector<Facts> facts;
  for (const Comparison& comparison : comparisons.all) {
    facts.push_back(comparison.facts);
    if (with_stage && !comparison.stage.empty()) {
      facts.back().emplace_back("stage", comparison.stage);
    }
  }
  return start_table(facts, std::move(name), std::move(title));
}

void add(Table& table, const Comparisons& comparisons, TableColumn column, Cell cell) {
  add_column(table, std::move(column), [&](std::size_t row) { return cell(comparisons.all[row]); });
}

/// The last column becomes the first.
void move_to_front(Table& table) {
  std::rotate(table.columns.begin(), table.columns.end() - 1, table.columns.end());
  for (auto& row : table.rows) std::rotate(row.begin(), row.end() - 1, row.end());
}

TableCell number(const Comparison& comparison) {
  if (!comparison.value) return TableMissing{comparison.reason};
  return TableNumber{*comparison.value, comparison.lower, comparison.upper};
}

TableCell difference(const Comparison& comparison) {
  return comparison.ratio ? TableCell("") : number(comparison);
}

TableCell ratio(const Comparison& comparison) {
  return comparison.ratio ? number(comparison) : TableCell("");
}

TableCell adjusted_p(const Comparison& comparison) {
  if (!comparison.adjusted_p) return TableMissing{comparison.reason};
  return TableNumber{*comparison.adjusted_p, {}, {}};
}

TableCell verdict(const Comparison& comparison) {
  switch (comparison.verdict) {
    case Verdict::less:
      return fmt::format("{} < {}", comparison.a, comparison.b);
    case Verdict::greater:
      return fmt::format("{} > {}", comparison.a, comparison.b);
    case Verdict::equal:
      return "equal";
    case Verdict::unresolved:
      return "unresolved";
    case Verdict::unknown:
      break;
  }
  return "could not tell: " + comparison.reason;
}

/// The family of the correction and what its intervals are.
std::string family_note(const Comparisons& comparisons) {
  double lowest = 1.0;
  double highest = 0.0;
  for (const Comparison& comparison : comparisons.all) {
    if (!comparison.adjusted_p) continue;
    lowest = std::min(lowest, comparison.confidence);
    highest = std::max(highest, comparison.confidence);
  }
  if (comparisons.tested == 0) return "Nothing could be compared over seeds";
  std::string note = fmt::format(
      "One family of {} tests after Holm 1979: that any of its verdicts is wrong has a probability "
      "of at most {:g}%. Each interval has the confidence at which Holm's procedure judged it "
      "({:.6g}% to {:.6g}%), so that it excludes equality exactly where the test does",
      comparisons.tested, 100.0 * comparisons.level, 100.0 * lowest, 100.0 * highest);
  const double first_level = comparisons.level / double(comparisons.tested);
  if (comparisons.smallest_p > first_level) {
    note += fmt::format(
        ". Nothing can be resolved: these seeds give no p-value below {:.2g}, and "
        "one would have to be below {:.2g}",
        comparisons.smallest_p, first_level);
  }
  return note;
}

}  // namespace

Table comparisons_table(const Comparisons& comparisons, std::string name, std::string title) {
  Table table = start(comparisons, std::move(name), std::move(title), false);
  if (comparisons.all.empty()) return table;
  const auto& all = comparisons.all;
  const bool differences = !std::ranges::all_of(all, &Comparison::ratio);
  const bool ratios = std::ranges::any_of(all, &Comparison::ratio);
  add(table, comparisons, {"metric", "", Alignment::left},
      [](const Comparison& c) -> TableCell { return c.quantity; });
  move_to_front(table);
  add(table, comparisons, {"a", "", Alignment::left},
      [](const Comparison& c) -> TableCell { return c.a; });
  add(table, comparisons, {"b", "", Alignment::left},
      [](const Comparison& c) -> TableCell { return c.b; });
  if (differences) add(table, comparisons, {"a - b", "", Alignment::right}, difference);
  if (ratios) add(table, comparisons, {"a / b", "", Alignment::right}, ratio);
  add(table, comparisons, {"unit", "", Alignment::left},
      [](const Comparison& c) -> TableCell { return c.unit; });
  add(table, comparisons, {"adjusted p", "", Alignment::right}, adjusted_p);
  add(table, comparisons, {"verdict", "", Alignment::left}, verdict);
  add(table, comparisons, {"better", "", Alignment::left},
      [](const Comparison& c) -> TableCell { return better_method(c); });
  table.notes.push_back(family_note(comparisons));
  return table;
}

Table orderings_table(const std::vector<Measurement>& measurements) {
  const Comparisons comparisons = compare_ratios(measurements);
  Table table = start(comparisons, "orderings", "Orderings", true);
  if (comparisons.all.empty()) return table;
  add(table, comparisons, {"statement", "", Alignment::left}, [](const Comparison& c) -> TableCell {
    return fmt::format("{0} {1} > {0} {2}", c.quantity, c.a, c.b);
  });
  move_to_front(table);
  add(table, comparisons, {"ratio", "", Alignment::right}, number);
  add(table, comparisons, {"verdict", "", Alignment::left}, [](const Comparison& c) -> TableCell {
    if (c.verdict == Verdict::greater) return "holds";
    return c.verdict == Verdict::less ? "does not hold" : "unresolved";
  });
  table.notes.emplace_back(
      "A statement holds where the whole interval of the ratio is above 1, does not hold where it "
      "is below 1, and is unresolved otherwise");
  table.notes.push_back(family_note(comparisons));
  return table;
}

}  // namespace occlab
