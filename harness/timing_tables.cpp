#include "harness/timing_tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "harness/table_rows.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr std::string_view time_prefix = "time_ms.";
constexpr std::string_view ratio_prefix = "time_ratio.";

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

std::string resolution_of(const PublishedTime& time) {
  return fmt::format("{}x{}", time.width, time.height);
}

bool several_resolutions(const PublishedTimes& published) {
  return std::ranges::any_of(published.times, [&](const PublishedTime& time) {
    return resolution_of(time) != resolution_of(published.times.front());
  });
}

/// Under which conditions a time was published.
bool fits(const PublishedTime& time, const Facts& facts) {
  return fmt::format("{}", time.samples) == fact(facts, "samples") &&
         fmt::format("{}", time.steps) == fact(facts, "steps");
}

/// The paper's time for a method under a row's conditions.
const PublishedTime* find_published(const PublishedTimes& published, const std::string& method,
                                    const Facts& facts, const std::string& origin) {
  const bool one_size = !several_resolutions(published);
  for (const PublishedTime& time : published.times) {
    if (time.method == method && time.origin == origin && fits(time, facts) &&
        (one_size || resolution_of(time) == fact(facts, "resolution"))) {
      return &time;
    }
  }
  return nullptr;
}

/// What a paper printed beside its table, and what is to be said of its numbers.
void add_remarks(Table& table, const PublishedTimes& published) {
  std::vector<std::string> remarks;
  for (const PublishedTime& time : published.times) {
    if (!time.remark.empty() && std::ranges::find(remarks, time.remark) == remarks.end()) {
      remarks.push_back(time.remark);
    }
  }
  table.notes.insert(table.notes.end(), remarks.begin(), remarks.end());
}

void add_published(Table& table, const std::vector<RowGroup>& groups, const std::string& baseline,
                   const PublishedTimes& published) {
  const std::string origin = published.times.front().origin;
  const auto find = [&](const RowGroup& group, const std::string& method) {
    return find_published(published, method, group.facts, origin);
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
  for (const PublishedTime& time : published.times) {
    if (time.origin == origin) continue;
    const auto base = std::ranges::find_if(published.times, [&](const PublishedTime& other) {
      return other.method == baseline && other.samples == time.samples &&
             other.steps == time.steps && other.origin == time.origin;
    });
    std::string note =
        fmt::format("The paper elsewhere ({}): {} {:g} ms for {} samples and {} steps", time.origin,
                    time.method, time.time_ms, time.samples, time.steps);
    if (base != published.times.end() && &*base != &time) {
      note += fmt::format(", {:.3f} times {}", time.time_ms / base->time_ms, baseline);
    }
    table.notes.push_back(std::move(note));
  }
  add_remarks(table, published);
}

/// What the brackets behind a ratio are.
std::string ratios_note(const std::string& baseline, const Rows& rows) {
  const long fewest = (*std::ranges::min_element(rows, {}, &Measurement::n))->n;
  return fmt::format(
      "ratios are medians of the ratios to {} pair by pair, in brackets their 95% intervals, "
      "interpolated between order statistics{}; repetitions {}",
      baseline,
      fewest < 6 ? " (of fewer than 6 repetitions: their range, which covers less than 95%)" : "",
      counts(rows));
}

/// What was printed to one decimal is within half of its last digit of the truth.
constexpr double printed_rounding = 0.05;

double slower_percent(double rate, double base_rate) { return 100.0 * (1.0 - rate / base_rate); }

/// Whether rounding explains the printed percentage.
bool consistent(const PublishedTime& time, const PublishedTime& base) {
  const double rate = 1000.0 / time.time_ms;
  const double base_rate = 1000.0 / base.time_ms;
  const double least = slower_percent(rate + printed_rounding, base_rate - printed_rounding);
  const double most = slower_percent(rate - printed_rounding, base_rate + printed_rounding);
  return *time.slower_percent + printed_rounding >= least &&
         *time.slower_percent - printed_rounding <= most;
}

/// A row of a table of frame rates: ours, the paper's, or both.
struct RateRow {
  Facts facts;
  const RowGroup* ours = nullptr;
  const PublishedTime* published = nullptr;
  const PublishedTime* published_base = nullptr;
};

/// The paper's rows under conditions that we timed, then ours that it does not have.
std::vector<RateRow> rate_rows(const std::vector<RowGroup>& groups, const std::string& baseline,
                               const PublishedTimes& published) {
  const std::string& origin = published.times.front().origin;
  std::vector<RateRow> rows;
  std::set<const RowGroup*> shown;
  for (const PublishedTime& time : published.times) {
    const auto here = [&](const RowGroup& group) {
      return fits(time, group.facts) && resolution_of(time) == fact(group.facts, "resolution");
    };
    const auto any = std::ranges::find_if(groups, here);
    if (time.origin != origin || any == groups.end()) continue;
    const auto ours = std::ranges::find_if(groups, [&](const RowGroup& group) {
      return here(group) && fact(group.facts, "method") == time.method;
    });
    RateRow row{any->facts, nullptr, &time, nullptr};
    row.published_base = find_published(published, baseline, any->facts, origin);
    if (ours != groups.end()) {
      row.facts = ours->facts;
      row.ours = &*ours;
      shown.insert(row.ours);
    } else {
      // Under the conditions of the others, as far as a paper says what they are.
      std::erase_if(row.facts, [](const auto& named) {
        return named.first != "method" && named.first != "resolution" && named.first != "samples" &&
               named.first != "steps";
      });
      std::ranges::find(row.facts, "method", &Facts::value_type::first)->second = time.method;
    }
    rows.push_back(std::move(row));
  }
  for (const RowGroup& group : groups) {
    if (!shown.contains(&group)) rows.push_back({group.facts, &group, nullptr, nullptr});
  }
  return rows;
}

TableCell our_rate(const RateRow& row) {
  if (!row.ours) {
    return TableMissing{fmt::format("not measured: '{}' was not timed", fact(row.facts, "method"))};
  }
  TableCell cell = number_cell(row.ours->find("time_ms.frame"));
  if (auto* number = std::get_if<TableNumber>(&cell)) {
    const TableNumber ms = *number;
    number->value = 1000.0 / ms.value;
    number->lower = 1000.0 / *ms.upper;
    number->upper = 1000.0 / *ms.lower;
  }
  return cell;
}

TableCell our_slowdown(const RateRow& row) {
  if (!row.ours) return our_rate(row);
  TableCell cell = number_cell(row.ours->find("time_ratio.frame"));
  if (auto* number = std::get_if<TableNumber>(&cell)) {
    const auto percent = [](double ratio) { return slower_percent(1.0, ratio); };
    number->value = percent(number->value);
    if (number->lower) number->lower = percent(*number->lower);
    if (number->upper) number->upper = percent(*number->upper);
  }
  return cell;
}

void note_contradictions(Table& table, const std::vector<RateRow>& rows,
                         const std::string& baseline) {
  for (const RateRow& row : rows) {
    const PublishedTime* const time = row.published;
    const PublishedTime* const base = row.published_base;
    if (!time || !base || !time->slower_percent || consistent(*time, *base)) continue;
    table.notes.push_back(fmt::format(
        "Contradiction in the published table: {} at {}, {} samples, is printed as {:.1f}% slower "
        "than {}; its {:.1f} fps against {:.1f} are {:.1f}%",
        time->method, resolution_of(*time), time->samples, *time->slower_percent, baseline,
        1000.0 / time->time_ms, 1000.0 / base->time_ms,
        slower_percent(1000.0 / time->time_ms, 1000.0 / base->time_ms)));
  }
}

void add_published_rates(Table& table, const std::vector<RateRow>& rows,
                         const std::string& baseline) {
  const TableMissing missing{"not published"};
  add_column(table, {"published", "fps", Alignment::right}, [&](std::size_t i) -> TableCell {
    if (!rows[i].published) return missing;
    return TableNumber{1000.0 / rows[i].published->time_ms, {}, {}};
  });
  add_column(table, {"published, as printed", "%", Alignment::right},
             [&](std::size_t i) -> TableCell {
               if (!rows[i].published || !rows[i].published->slower_percent) return missing;
               return TableNumber{*rows[i].published->slower_percent, {}, {}};
             });
  add_column(table, {"published, recomputed", "%", Alignment::right},
             [&](std::size_t i) -> TableCell {
               const PublishedTime* const time = rows[i].published;
               if (!time || !rows[i].published_base) return missing;
               if (time->method == baseline) return TableNumber{0.0, {}, {}};
               return TableNumber{
                   slower_percent(1000.0 / time->time_ms, 1000.0 / rows[i].published_base->time_ms),
                   {},
                   {}};
             });
}

}  // namespace

Table timing_table(const std::vector<Measurement>& measurements,
                   const TimingTableSettings& settings,
                   const std::optional<PublishedTimes>& published) {
  const std::string& baseline = settings.baseline;
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
      fmt::format("Ours: medians with the quartiles in brackets; frame is the whole by wall clock, "
                  "rest what of it "
                  "lies in no pass; {}",
                  ratios_note(baseline, rows)));
  if (published) add_published(table, groups, baseline, *published);
  table.notes.insert(table.notes.end(), settings.notes.begin(), settings.notes.end());
  return table;
}

Table frame_rate_table(const std::vector<Measurement>& measurements,
                       const TimingTableSettings& settings, const PublishedTimes& published) {
  const Rows rows = select_rows(measurements, is_time);
  const std::vector<RowGroup> groups = group_rows(rows);
  const std::vector<RateRow> rates =
      rows.empty() ? std::vector<RateRow>() : rate_rows(groups, settings.baseline, published);
  std::vector<Facts> facts;
  for (const RateRow& row : rates) facts.push_back(row.facts);
  if (rates.empty()) return start_table(facts, "frame_rates", "Frame rates");
  Table table = start_table(
      facts, "frame_rates",
      fmt::format("Frame rates on {}, by {}", one_value(rows, &Measurement::device, "devices"),
                  one_value(rows, &Measurement::clock, "clocks")));
  add_column(table, {"ours", "fps", Alignment::right},
             [&](std::size_t i) { return our_rate(rates[i]); });
  add_column(table, {"slower than " + settings.baseline, "%", Alignment::right},
             [&](std::size_t i) { return our_slowdown(rates[i]); });
  add_published_rates(table, rates, settings.baseline);
  table.notes.push_back(fmt::format(
      "Ours: whole frames, G-buffer included, from medians of their times, quartiles in brackets; "
      "slower: 1 - fps / fps of {}; {}",
      settings.baseline, ratios_note(settings.baseline, rows)));
  const PublishedTime& first = published.times.front();
  table.notes.push_back(
      fmt::format("Published: {}, {}; {}", published.source, first.origin, first.device));
  note_contradictions(table, rates, settings.baseline);
  add_remarks(table, published);
  table.notes.insert(table.notes.end(), settings.notes.begin(), settings.notes.end());
  return table;
}

Table scaling_table(const std::vector<Measurement>& measurements) {
  const Rows rows = select_rows(measurements, is_exponent);
  struct Parts {
    std::string axis;
    std::string pass;
  };
  const auto parts = [](const Measurement& m) {
    const std::size_t first = m.metric.find('.') + 1;
    const std::size_t last = m.metric.rfind('.');
    return Parts{m.metric.substr(first, last - first), m.metric.substr(last + 1)};
  };
  std::vector<std::pair<std::string, std::string>> places;  // axis and method
  std::vector<std::string> passes;
  std::vector<Facts> facts;
  for (const Measurement* m : rows) {
    const auto [axis, pass] = parts(*m);
    if (std::ranges::find(passes, pass) == passes.end()) passes.push_back(pass);
    if (std::ranges::find(places, std::pair(axis, m->method)) != places.end()) continue;
    places.emplace_back(axis, m->method);
    Facts row = facts_of(*m);
    row.insert(row.begin(), {"varied", axis});
    facts.push_back(std::move(row));
  }
  Table table = start_table(facts, "scaling", "How times grow: exponents of power laws");
  const auto find = [&](std::size_t row, const std::string& pass) -> const Measurement* {
    const std::string metric = fmt::format("time_exponent.{}.{}", places[row].first, pass);
    const auto found = std::ranges::find_if(rows, [&](const Measurement* m) {
      return m->metric == metric && m->method == places[row].second;
    });
    return found == rows.end() ? nullptr : *found;
  };
  for (const std::string& pass : passes) {
    add_column(table, {pass, "", Alignment::right},
               [&](std::size_t row) { return number_cell(find(row, pass)); });
    add_column(table, {pass + ", points", "", Alignment::right}, [&](std::size_t row) -> TableCell {
      const Measurement* const m = find(row, pass);
      if (!m || !m->value) return number_cell(m);
      return std::to_string(m->n);
    });
  }
  if (rows.empty()) return table;
  table.notes.emplace_back(
      "An exponent b says that the time grows as x^b: least squares in log x and log t in every "
      "repetition, the mean over the repetitions, in brackets its 95% interval (Student). "
      "Resolution "
      "counts pixels. Where times bend, the smallest x are left out, down to three points: "
      "'points' "
      "says how many were used");
  return table;
}

}  // namespace occlab
