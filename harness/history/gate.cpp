#include "harness/history/gate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <unordered_map>

#include "renderers/scene/error.h"

namespace occlab::history {
namespace {

constexpr double stated_confidence = 0.95;

/// Whether a series is held to the baseline; the others repeat it, or are not what a method does.
bool judged(const SeriesValues& values, const GateSettings& settings) {
  const std::string& metric = values.series.metric;
  // A change of the bias is one of the rmse, which is judged seed by seed.
  constexpr std::array<std::string_view, 3> implied = {"bias", "bias_squared", "mse"};
  if (std::ranges::find(implied, metric) != implied.end()) return false;
  for (const char* prefix : {"reference_", "budget_", "failure_", "time_exponent."}) {
    if (metric.starts_with(prefix)) return false;
  }
  if (metric.starts_with("time_ms.")) return settings.absolute_times;
  const bool of_itself = values.value == 1.0 && values.lower == 1.0 && values.upper == 1.0;
  return !(metric.starts_with("time_ratio.") && of_itself);
}

bool is_time_series(const Series& series) { return series.metric.starts_with("time_"); }

using Index = std::unordered_map<std::string, const SeriesValues*>;

Index index_of(const RunData& run) {
  Index index;
  for (const SeriesValues& values : run.series) {
    index.emplace(series_key_on_any_device(values.series), &values);
  }
  return index;
}

std::vector<Index> indices_of(const std::vector<RunData>& runs) {
  std::vector<Index> indices;
  for (const RunData& run : runs) indices.push_back(index_of(run));
  return indices;
}

/// Each series of the runs as the first has it that measured it.
std::vector<const SeriesValues*> all_series(const std::vector<RunData>& runs) {
  std::vector<const SeriesValues*> all;
  std::unordered_map<std::string, std::size_t> places;
  for (const RunData& run : runs) {
    for (const SeriesValues& values : run.series) {
      const auto [place, added] = places.try_emplace(series_key(values.series), all.size());
      if (added) {
        all.push_back(&values);
      } else if (const SeriesValues*& known = all[place->second]; !known->value) {
        known = &values;
      }
    }
  }
  return all;
}

/// Results that were added to the history before they are checked are there a second time.
bool is_one_of(const GateSide& side, const RunData& run) {
  return run.facts.run.is_object() && std::ranges::any_of(side.runs, [&](const RunData& other) {
           return other.facts.run == run.facts.run;
         });
}

/// The times of a series in every run of the same device.
std::vector<double> times_in(const std::vector<Index>& runs, const std::string& key,
                             const std::string& device) {
  std::vector<double> times;
  for (const Index& run : runs) {
    const auto found = run.find(key);
    if (found == run.end() || !found->second->value) continue;
    if (found->second->series.device == device) times.push_back(*found->second->value);
  }
  return times;
}

/// A finding with its test, before the correction.
struct Pending {
  Finding finding;
  EffectTest test;
};

class Gate {
 public:
  Gate(const GateSide& baseline, const GateSide& results,
       const std::vector<std::vector<RunData>>& other_runs, const GateSettings& settings)
      : settings_(settings),
        baseline_(all_series(baseline.runs)),
        before_(indices_of(baseline.runs)),
        after_(indices_of(results.runs)),
        tests_(baseline_.size()) {
    for (const auto& group : other_runs) {
      others_.emplace_back();
      for (const RunData& run : group) {
        if (!is_one_of(results, run)) others_.back().push_back(index_of(run));
      }
    }
    for (const SeriesValues* values : baseline_) floors_.add(values->series, values->value);
  }

  std::vector<Pending> compare_all() {
    std::vector<Pending> all;
    for (const SeriesValues* values : baseline_) {
      if (!values->value || !judged(*values, settings_)) continue;
      all.push_back(compare(*values));
    }
    return all;
  }

 private:
  Pending compare(const SeriesValues& before) {
    Pending pending;
    Finding& finding = pending.finding;
    finding.series = before.series;
    finding.before = before.value;
    finding.relative = is_relative(class_of(before.series.metric));
    finding.minimum = settings_.minimum.of(class_of(before.series.metric));
    finding.floor = floors_.of(before.series);
    const std::string key = series_key_on_any_device(before.series);
    const SeriesValues* after = find(key);
    if (!after || !after->value) {
      finding.outcome = Outcome::missing;
      finding.reason = after ? after->reason : "the results do not have it";
      return pending;
    }
    finding.after = after->value;
    pending.test = test(before, *after, key);
    finding.effect = pending.test.effect;
    finding.how = pending.test.how;
    finding.reason = pending.test.reason;
    return pending;
  }

  /// In the first of the results' runs that has it.
  const SeriesValues* find(const std::string& key) const {
    for (const Index& run : after_) {
      const auto found = run.find(key);
      if (found != run.end()) return found->second;
    }
    return nullptr;
  }

  EffectTest test(const SeriesValues& before, const SeriesValues& after, const std::string& key) {
    if (before.series.metric == "noise") return compare_estimates(before, after);
    if (!is_time_series(before.series)) return tests_.compare(before, after);
    if (before.series.device != after.series.device) {
      EffectTest none;
      none.reason =
          fmt::format("times of another device or by another clock are not compared: {}, before {}",
                      after.series.device, before.series.device);
      return none;
    }
    std::vector<std::vector<double>> others;
    for (const std::vector<Index>& group : others_) {
      others.push_back(times_in(group, key, before.series.device));
    }
    return compare_times(times_in(before_, key, before.series.device),
                         times_in(after_, key, before.series.device), others);
  }

  const GateSettings& settings_;
  std::vector<const SeriesValues*> baseline_;
  std::vector<Index> before_;
  std::vector<Index> after_;
  std::vector<std::vector<Index>> others_;
  SeedTests tests_;
  NoiseFloors floors_;
};

Outcome direction_outcome(const Finding& finding) {
  const Direction direction = direction_of(finding.series.metric);
  if (direction == Direction::none) return Outcome::changed;
  return (*finding.effect > 0.0) == (direction == Direction::lower) ? Outcome::worse
                                                                    : Outcome::better;
}

void judge(Pending& pending, const HolmTest& corrected) {
  Finding& finding = pending.finding;
  finding.adjusted_p = corrected.adjusted_p;
  const Interval interval = pending.test.interval(stated_confidence);
  finding.lower = interval.low;
  finding.upper = interval.high;
  const bool large = std::abs(*finding.effect) >= finding.minimum;
  if (corrected.rejected && large) {
    finding.outcome = direction_outcome(finding);
  } else if (-finding.minimum <= interval.low && interval.high <= finding.minimum) {
    finding.outcome = Outcome::same;
  } else {
    finding.outcome = Outcome::unsure;
    finding.reason = large ? "the change may be chance" : "the interval reaches beyond the minimum";
  }
}

/// Holm's correction over the tested of one family.
void judge_family(std::vector<Pending>& all, bool times, double level, GateReport& report) {
  std::vector<Pending*> tested;
  std::vector<double> p_values;
  double smallest_p = 0.0;
  double least_smallest_p = 1.0;
  for (Pending& pending : all) {
    if (is_time_series(pending.finding.series) != times) continue;
    if (pending.test.identical) {
      pending.finding.outcome = Outcome::same;
      pending.finding.lower = pending.finding.upper = 0.0;
    }
    if (!pending.test.p_value || !std::isfinite(*pending.test.p_value)) continue;
    tested.push_back(&pending);
    p_values.push_back(*pending.test.p_value);
    smallest_p = std::max(smallest_p, pending.test.smallest_p);
    least_smallest_p = std::min(least_smallest_p, pending.test.smallest_p);
  }
  if (tested.empty()) return;
  const std::vector<HolmTest> corrected = holm(p_values, level);
  for (std::size_t i = 0; i < tested.size(); ++i) judge(*tested[i], corrected[i]);
  if (smallest_p * double(tested.size()) > level) {
    report.notes.push_back(fmt::format(
        "Too few seeds: the least p-value they can give is {:.2g}, and {} tests at {:g} ask for "
        "{:.2g}: not every regression can be told. Use 8 seeds or more",
        smallest_p, tested.size(), level, level / double(tested.size())));
  }
  if (least_smallest_p * double(tested.size()) <= level) return;
  for (Pending* pending : tested) {  // no value whatever could have been told from the baseline's
    if (pending->finding.outcome != Outcome::unsure) continue;
    pending->finding.adjusted_p.reset();
    pending->finding.reason = "too few seeds";
  }
}

double severity(const Finding& finding) {
  return finding.effect ? std::abs(*finding.effect) / finding.minimum : 0.0;
}

}  // namespace

std::string to_string(Outcome outcome) {
  constexpr std::array<const char*, 6> names = {"WORSE",  "CHANGED", "MISSING",
                                                "UNSURE", "BETTER",  "SAME"};
  return names[std::size_t(outcome)];
}

std::size_t GateReport::count(Outcome outcome) const {
  return std::size_t(std::ranges::count(findings, outcome, &Finding::outcome));
}

std::size_t GateReport::compared() const {
  return std::size_t(std::ranges::count_if(findings, [](const Finding& finding) {
    return finding.adjusted_p || finding.outcome == Outcome::same;
  }));
}

GateReport run_gate(const GateSide& baseline, const GateSide& results,
                    const std::vector<std::vector<RunData>>& other_runs,
                    const GateSettings& settings) {
  GateReport report;
  const RunData& before = baseline.runs.front();
  const RunData& after = results.runs.front();
  report.baseline = before.name;
  report.results = after.name;
  report.experiment = after.facts.experiment;
  report.level = settings.level;
  std::vector<Pending> all = Gate(baseline, results, other_runs, settings).compare_all();
  const auto has = [&](bool times) {
    return std::ranges::any_of(all, [&](const Pending& pending) {
      return is_time_series(pending.finding.series) == times && pending.test.p_value;
    });
  };
  const double level = has(true) && has(false) ? settings.level / 2.0 : settings.level;
  for (const bool times : {false, true}) judge_family(all, times, level, report);
  for (Pending& pending : all) report.findings.push_back(std::move(pending.finding));
  std::ranges::stable_sort(report.findings, [](const Finding& a, const Finding& b) {
    return a.outcome != b.outcome ? a.outcome < b.outcome : severity(a) > severity(b);
  });
  describe_sides(baseline, results, settings, report);
  return report;
}

}  // namespace occlab::history
