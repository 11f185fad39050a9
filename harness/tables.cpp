#include "harness/tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <functional>
#include <set>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

using Rows = std::vector<const Measurement*>;
using Facts = std::vector<std::pair<std::string, std::string>>;

constexpr std::string_view time_prefix = "time_ms.";
constexpr std::string_view ratio_prefix = "time_ratio.";

bool is_time(const Measurement& m) {
  return m.metric.starts_with(time_prefix) || m.metric.starts_with(ratio_prefix);
}

/// What only several seeds together can tell.
bool is_over_seeds(const Measurement& m) {
  constexpr std::array<std::string_view, 4> metrics = {"noise", "bias", "bias_squared", "mse"};
  return std::ranges::find(metrics, m.metric) != metrics.end();
}

/// "noise_ratio.ssdo/s3ho" split into its three names; empty for any other metric.
std::vector<std::string> ordering_parts(const std::string& metric) {
  constexpr std::string_view middle = "_ratio.";
  const std::size_t dot = metric.find(middle);
  const std::size_t slash = metric.find('/', dot == std::string::npos ? 0 : dot);
  if (dot == std::string::npos || slash == std::string::npos) return {};
  const std::size_t first = dot + middle.size();
  return {metric.substr(0, dot), metric.substr(first, slash - first), metric.substr(slash + 1)};
}

Rows filter(const std::vector<Measurement>& measurements,
            const std::function<bool(const Measurement&)>& wanted) {
  Rows rows;
  for (const Measurement& m : measurements) {
    if (m.seed == "all" && wanted(m)) rows.push_back(&m);
  }
  return rows;
}

/// What tells rows apart, in the order of the columns; empty facts are left out.
Facts facts_of(const Measurement& m) {
  Facts facts;
  for (const auto& [name, value] : Facts{{"experiment", m.experiment},
                                         {"scene", m.scene},
                                         {"view", m.view},
                                         {"resolution", m.resolution},
                                         {"probe", m.probe},
                                         {"method", m.method}}) {
    if (!value.empty()) facts.emplace_back(name, value);
  }
  facts.insert(facts.end(), m.parameters.begin(), m.parameters.end());
  return facts;
}

std::string fact(const Facts& facts, const std::string& name) {
  const auto found = std::ranges::find(facts, name, &Facts::value_type::first);
  return found == facts.end() ? "" : found->second;
}

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

TableCell number_cell(const Measurement* m) {
  if (!m) return TableMissing{"not measured"};
  if (!m->value) return TableMissing{m->reason};
  return TableNumber{*m->value, m->lower, m->upper};
}

/// "n = 8", or "n = 1 to 8".
std::string counts(const Rows& rows) {
  const auto [low, high] = std::ranges::minmax_element(rows, {}, &Measurement::n);
  return (*low)->n == (*high)->n ? fmt::format("n = {}", (*low)->n)
                                 : fmt::format("n = {} to {}", (*low)->n, (*high)->n);
}

/// A row of the table under construction: its facts and the measurements that share them.
struct Group {
  Facts facts;
  Rows measurements;

  const Measurement* find(const std::string& metric) const {
    const auto found = std::ranges::find(measurements, metric, &Measurement::metric);
    return found == measurements.end() ? nullptr : *found;
  }
};

/// Rows in order of appearance; one value for each metric of a row.
std::vector<Group> group_rows(const Rows& rows) {
  std::vector<Group> groups;
  for (const Measurement* m : rows) {
    const Facts facts = facts_of(*m);
    auto group = std::ranges::find(groups, facts, &Group::facts);
    if (group == groups.end()) group = groups.insert(groups.end(), Group{facts, {}});
    if (group->find(m->metric)) {
      std::vector<std::string> row;
      for (const auto& [name, value] : facts) row.push_back(name + " = " + value);
      throw InputError(
          fmt::format("measurements: '{}' is there twice for {}", m->metric, fmt::join(row, ", ")));
    }
    group->measurements.push_back(m);
  }
  return groups;
}

/// A table of rows and their labels, to which the columns of numbers are added.
Table start_table(const std::vector<Group>& groups, std::string name, std::string title) {
  std::vector<Facts> facts;
  for (const Group& group : groups) facts.push_back(group.facts);
  const Labels labels = make_labels(facts);
  Table table{std::move(name), std::move(title), {}, {}, {}};
  for (const std::string& label : labels.columns) {
    const bool text = label == "method" || label == "probe" || label == "scene" || label == "view";
    table.columns.push_back({label, "", text ? Alignment::left : Alignment::right});
  }
  for (const Facts& row : facts) {
    table.rows.emplace_back();
    for (const std::string& label : labels.columns)
      table.rows.back().emplace_back(fact(row, label));
  }
  if (!labels.note.empty()) table.notes.push_back(labels.note);
  return table;
}

/// One column, with the cell that `cell` makes of each row.
void add_column(Table& table, const std::vector<Group>& groups, TableColumn column,
                const std::function<TableCell(const Group&)>& cell) {
  table.columns.push_back(std::move(column));
  for (std::size_t i = 0; i < groups.size(); ++i) table.rows[i].push_back(cell(groups[i]));
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

/// One column for each metric there is.
Table metric_table(const Rows& rows, std::string name, std::string title) {
  const std::vector<Group> groups = group_rows(rows);
  Table table = start_table(groups, std::move(name), std::move(title));
  for (const auto& [metric, unit] : metrics_with_units(rows)) {
    add_column(
        table, groups, {metric, unit, Alignment::right},
        [&, &wanted = metric](const Group& group) { return number_cell(group.find(wanted)); });
  }
  if (!rows.empty()) {
    table.notes.push_back(fmt::format(
        "Over the seeds, with 95% intervals in brackets where there are several seeds; {}",
        counts(rows)));
  }
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

void add_published(Table& table, const std::vector<Group>& groups, const std::string& baseline,
                   const PublishedTimes& published) {
  const std::string origin = published.times.front().origin;
  const auto find = [&](const Group& group, const std::string& method) {
    return find_published(published, method, fact(group.facts, "samples"),
                          fact(group.facts, "steps"), origin);
  };
  const TableMissing missing{"not published"};
  add_column(table, groups, {"published", "ms", Alignment::right},
             [&](const Group& group) -> TableCell {
               const PublishedTime* time = find(group, fact(group.facts, "method"));
               if (!time) return missing;
               return TableNumber{time->time_ms, {}, {}};
             });
  add_column(table, groups, {"published / " + baseline, "", Alignment::right},
             [&](const Group& group) -> TableCell {
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

Table accuracy_table(const std::vector<Measurement>& measurements, const std::string& stage) {
  const Rows rows = filter(measurements, [&](const Measurement& m) {
    return m.stage == stage && !is_time(m) && !is_over_seeds(m) && ordering_parts(m.metric).empty();
  });
  return metric_table(rows, "accuracy_" + stage, fmt::format("Accuracy, {}", stage));
}

Table noise_table(const std::vector<Measurement>& measurements, const std::string& stage) {
  const Rows rows = filter(
      measurements, [&](const Measurement& m) { return m.stage == stage && is_over_seeds(m); });
  return metric_table(rows, "noise_" + stage, fmt::format("Noise and bias, {}", stage));
}

Table timing_table(const std::vector<Measurement>& measurements, const std::string& baseline,
                   const std::optional<PublishedTimes>& published) {
  const Rows rows = filter(measurements, is_time);
  const std::vector<Group> groups = group_rows(rows);
  if (rows.empty()) return start_table(groups, "timing", "Times");
  const std::string& device = one_value(rows, &Measurement::device, "devices");
  const std::string& clock = one_value(rows, &Measurement::clock, "clocks");
  Table table = start_table(groups, "timing", fmt::format("Times on {}, by {}", device, clock));
  for (const auto& [metric, unit] : metrics_with_units(rows)) {
    if (!metric.starts_with(time_prefix)) continue;
    const std::string pass = metric.substr(time_prefix.size());
    const std::string ratio = std::string(ratio_prefix) + pass;
    add_column(table, groups, {pass, "ms", Alignment::right},
               [&, &time = metric](const Group& group) { return number_cell(group.find(time)); });
    if (std::ranges::find(rows, ratio, &Measurement::metric) == rows.end()) continue;
    add_column(table, groups, {pass + " / " + baseline, "", Alignment::right},
               [&](const Group& group) { return number_cell(group.find(ratio)); });
  }
  table.notes.push_back(
      fmt::format("Ours: medians with the quartiles in brackets; ratios are medians of the ratios "
                  "to {} pair by pair, with distribution-free intervals between their order "
                  "statistics, of at least 95% from 6 repetitions on; repetitions {}",
                  baseline, counts(rows)));
  if (published) add_published(table, groups, baseline, *published);
  return table;
}

Table orderings_table(const std::vector<Measurement>& measurements) {
  const Rows rows =
      filter(measurements, [](const Measurement& m) { return !ordering_parts(m.metric).empty(); });
  // Every measurement is a row of its own; the method is part of the statement.
  std::vector<Group> groups;
  for (const Measurement* m : rows) {
    const std::vector<std::string> parts = ordering_parts(m->metric);
    Facts facts = facts_of(*m);
    std::erase_if(facts, [](const auto& f) { return f.first == "method"; });
    if (!m->stage.empty()) facts.emplace_back("stage", m->stage);
    groups.push_back({std::move(facts), {m}});
  }
  Table table = start_table(groups, "orderings", "Orderings");
  const auto statement = [](const Group& group) -> TableCell {
    const std::vector<std::string> parts = ordering_parts(group.measurements.front()->metric);
    return fmt::format("{0} {1} > {0} {2}", parts[0], parts[1], parts[2]);
  };
  table.columns.insert(table.columns.begin(), {"statement", "", Alignment::left});
  for (std::size_t i = 0; i < groups.size(); ++i) {
    table.rows[i].insert(table.rows[i].begin(), statement(groups[i]));
  }
  add_column(table, groups, {"ratio", "", Alignment::right},
             [](const Group& group) { return number_cell(group.measurements.front()); });
  add_column(table, groups, {"verdict", "", Alignment::left}, [](const Group& group) -> TableCell {
    const Measurement& m = *group.measurements.front();
    if (m.lower && *m.lower > 1) return "holds";
    if (m.upper && *m.upper < 1) return "does not hold";
    return "unresolved";
  });
  table.notes.emplace_back(
      "A statement holds where the whole 95% interval of the ratio is above 1, does not hold where "
      "it is below 1, and is unresolved otherwise");
  return table;
}

}  // namespace occlab
