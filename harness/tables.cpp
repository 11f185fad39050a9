#include "harness/tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "harness/table_rows.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr std::string_view time_prefix = "time_ms.";
constexpr std::string_view ratio_prefix = "time_ratio.";

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

const std::string& one_value(const Rows& rows, std::string Measurement::*field,
                             std::string_view what) {
  for (const Measurement* m : rows) {
    if (m->*field != rows.front()->*field) {
      throw InputError(
          fmt::format("measurements: times of the {} '{}' and '{}' cannot stand in one "
                      "table",
                      what, rows.front()->*field, m->*field));
    }
  }
  return rows.front()->*field;
}

/// The paper's time for a method, number of samples and number of steps.
const PublishedTime* find_published(const PublishedTimes& published, const std::string& method,
                                    const std::string& samples, const std::string& steps,
                                    const std::string& origin) {
  for (const PublishedTime& time : published.times) {
    if (time.method == method && fmt::format("{}", time.samples) == samples &&
        fmt::format("{}", time.steps) == steps && time.origin == origin) {
      return &time;
    }
  }
  return nullptr;
}

void add_published(Table& table, const std::vector<RowGroup>& groups, const std::string& baseline,
                   const PublishedTimes& published) {
  const std::string origin = published.times.front().origin;
  const auto find = [&](const RowGroup& group, const std::string& method) {
    return find_published(published, method, fact(group.facts, "samples"),
                          fact(group.facts, "steps"), origin);
  };
  const TableMissing missing{"not published"};
  add_column(table, {"published", "ms", Alignment::right}, [&](std::size_t row) -> TableCell {
    const RowGroup& group = groups[row];
    const PublishedTime* time = find(group, fact(group.facts, "method"));
    if (!time) return missing;
    return TableNumber{time->time_ms, {}, {}};
  });
  add_column(table, {"published / " + baseline, "", Alignment::right},
             [&](std::size_t row) -> TableCell {
               const RowGroup& group = groups[row];
               const PublishedTime* time = find(group, fact(group.facts, "method"));
               const PublishedTime* base = find(group, baseline);
               if (!time || !base) return missing;
               return TableNumber{time->time_ms / base->time_ms, {}, {}};
             });
  const PublishedTime& first = published.times.front();
  table.notes.push_back(fmt::format("Published: {}, {}; {}, {}x{}", published.source, origin,
                                    first.device, first.width, first.height));
  std::vector<std::string> remarks;
  for (const PublishedTime& time : published.times) {
    if (time.origin != origin) {
      const PublishedTime* base =
          find_published(published, baseline, fmt::format("{}", time.samples),
                         fmt::format("{}", time.steps), time.origin);
      std::string note = fmt::format(
          "The paper elsewhere ({}): {} {:g} ms for {} samples and {} "
          "steps",
          time.origin, time.method, time.time_ms, time.samples, time.steps);
      if (base && base != &time) {
        note += fmt::format(", {:.3f} times {}", time.time_ms / base->time_ms, baseline);
      }
      table.notes.push_back(std::move(note));
    }
    if (!time.remark.empty() && std::ranges::find(remarks, time.remark) == remarks.end()) {
      remarks.push_back(time.remark);
    }
  }
  table.notes.insert(table.notes.end(), remarks.begin(), remarks.end());
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

Table timing_table(const std::vector<Measurement>& measurements, const std::string& baseline,
                   const std::optional<PublishedTimes>& published) {
  const Rows rows = select_rows(measurements, is_time);
  const std::vector<RowGroup> groups = group_rows(rows);
  if (rows.empty()) return start_table(groups, "timing", "Times");
  const std::string& device = one_value(rows, &Measurement::device, "devices");
  const std::string& clock = one_value(rows, &Measurement::clock, "clocks");
  Table table = start_table(groups, "timing", fmt::format("Times on {}, by {}", device, clock));
  for (const auto& [metric, unit] : metrics_with_units(rows)) {
    if (!metric.starts_with(time_prefix)) continue;
    const std::string pass = metric.substr(time_prefix.size());
    const std::string ratio = std::string(ratio_prefix) + pass;
    add_column(table, {pass, "ms", Alignment::right}, [&, &time = metric](std::size_t row) {
      return number_cell(groups[row].find(time));
    });
    if (std::ranges::find(rows, ratio, &Measurement::metric) == rows.end()) continue;
    add_column(table, {pass + " / " + baseline, "", Alignment::right},
               [&](std::size_t row) { return number_cell(groups[row].find(ratio)); });
  }
  table.notes.push_back(
      fmt::format("Ours: medians with the quartiles in brackets; ratios are medians of the ratios "
                  "to {} pair by pair, with distribution-free intervals between their order "
                  "statistics, of at least 95% from 6 repetitions on; repetitions {}",
                  baseline, counts(rows)));
  if (published) add_published(table, groups, baseline, *published);
  return table;
}

}  // namespace occlab
