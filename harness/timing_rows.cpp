#include "harness/timing_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "harness/statistics.h"
#include "harness/timing_statistics.h"

namespace occlab {
namespace {

constexpr std::size_t fewest_values = 3;

Measurement row_of(const Measurement& facts, const std::string& metric, const char* unit,
                   std::size_t n) {
  Measurement row = facts;
  row.seed = "all";
  row.metric = metric;
  row.unit = unit;
  row.n = long(n);
  return row;
}

Measurement& missing(Measurement& row, std::size_t repetitions, const std::string& rejection) {
  row.reason = fmt::format("only {} of {} repetitions can be believed{}{}", row.n, repetitions,
                           rejection.empty() ? "" : "; the first that cannot: ", rejection);
  return row;
}

Measurement time_row(const TimedSeries& series, const PassSeries& pass) {
  const std::vector<double> times = believed(pass.ms);
  Measurement row = row_of(series.facts, "time_ms." + pass.pass, "ms", times.size());
  if (times.size() < fewest_values) return missing(row, pass.ms.size(), series.rejection);
  const Quartiles summary = quartiles(times);
  row.value = summary.median;
  row.lower = summary.lower;
  row.upper = summary.upper;
  return row;
}

Measurement ratio_row(const TimedSeries& series, const PassSeries& pass,
                      const std::vector<double>& baseline) {
  const std::vector<double> ratios = paired_ratios_of(pass.ms, baseline);
  Measurement row = row_of(series.facts, "time_ratio." + pass.pass, "", ratios.size());
  if (ratios.size() < fewest_values) return missing(row, pass.ms.size(), series.rejection);
  const Interval interval = interpolated_median_interval(ratios);
  row.value = median(ratios);
  row.lower = interval.low;
  row.upper = interval.high;
  return row;
}

/// The G-buffer is drawn alike for every method, and what lies between the passes is nobody's.
bool has_ratio(const std::string& pass) { return pass != "gbuffer" && pass != rest_pass; }

std::vector<RepeatedPoint> points_on(const std::vector<TimedSeries>& all, const std::string& method,
                                     const std::string& axis, const std::string& pass) {
  std::vector<RepeatedPoint> points;
  std::size_t shortest = 0;
  for (const TimedSeries& series : all) {
    const auto place = std::ranges::find(series.axes, axis, [](const auto& p) { return p.first; });
    const std::vector<double>* times = series.times.find(pass);
    if (series.facts.method != method || place == series.axes.end() || !times) continue;
    shortest = points.empty() ? times->size() : std::min(shortest, times->size());
    points.push_back({place->second, *times});
  }
  for (RepeatedPoint& point : points) point.y.resize(shortest);
  return points;
}

void add_exponent(Exponents& exponents, std::vector<RepeatedPoint> points, const Measurement& facts,
                  const std::string& axis, const std::string& pass) {
  Measurement row = row_of(facts, fmt::format("time_exponent.{}.{}", axis, pass), "", 0);
  const std::size_t all = points.size();
  if (all < 2) {
    row.reason = "one point only";
    exponents.rows.push_back(std::move(row));
    return;
  }
  const std::optional<PowerLaw> law = fit_power_law(std::move(points));
  if (!law) {
    row.reason = "no repetition has all points";
  } else {
    row.value = law->exponent;
    row.n = law->points;
    if (law->interval) {
      row.lower = law->interval->low;
      row.upper = law->interval->high;
    }
    if (law->curved) {
      exponents.notes.push_back(
          fmt::format("{}: the {} over {} still bends between the last {} of {} points",
                      facts.method, pass, axis, law->points, all));
    }
  }
  exponents.rows.push_back(std::move(row));
}

template <typename Values>
void add_new(Values& values, const std::string& value) {
  if (std::ranges::find(values, value) == values.end()) values.push_back(value);
}

}  // namespace

std::vector<Measurement> time_rows(const TimedSeries& series) {
  std::vector<Measurement> rows;
  for (const PassSeries& pass : series.times.passes) {
    rows.push_back(time_row(series, pass));
    const std::vector<double>* baseline = series.baseline.find(pass.pass);
    if (baseline && has_ratio(pass.pass)) rows.push_back(ratio_row(series, pass, *baseline));
  }
  return rows;
}

Exponents fit_exponents(const std::vector<TimedSeries>& all, const Measurement& shared) {
  std::vector<std::string> axes;
  std::vector<std::string> methods;
  std::vector<std::string> passes;
  for (const TimedSeries& series : all) {
    add_new(methods, series.facts.method);
    for (const auto& [axis, place] : series.axes) add_new(axes, axis);
    for (const PassSeries& pass : series.times.passes) {
      if (pass.pass != rest_pass) add_new(passes, pass.pass);
    }
  }
  Exponents exponents;
  for (const std::string& axis : axes) {
    for (const std::string& method : methods) {
      Measurement facts = shared;
      facts.method = method;
      for (const std::string& pass : passes) {
        std::vector<RepeatedPoint> points = points_on(all, method, axis, pass);
        if (!points.empty()) add_exponent(exponents, std::move(points), facts, axis, pass);
      }
    }
  }
  return exponents;
}

std::vector<std::string> loop_notes(const LoopResult& loop, const TimingLimits& limits) {
  std::vector<std::string> notes;
  const std::string widest = std::isfinite(loop.widest_interval)
                                 ? fmt::format("the widest interval of a ratio is {:.1f}% of it",
                                               100.0 * loop.widest_interval)
                                 : "a ratio has no interval";
  notes.push_back(fmt::format(
      "{} repetitions in {:.3g} s, ended because {}", loop.repetitions, loop.seconds,
      loop.within
          ? fmt::format("every interval is within {:g}%", 100.0 * wanted_interval_width)
          : fmt::format("the budget of {:g} s was spent: {}", limits.budget_seconds, widest)));
  notes.push_back(fmt::format(
      "Drift: frames of the last third took {:.3f} times those of the first", loop.drift));
  if (std::abs(loop.drift - 1.0) > tolerated_drift) {
    notes.push_back(
        fmt::format("WARNING: the drift is beyond {:g}%, the machine changed meanwhile. Ratios are "
                    "paired within "
                    "a repetition; the times in ms are not to be compared with another run's",
                    100.0 * tolerated_drift));
  }
  if (loop.rejected_passes > 0) {
    notes.push_back(fmt::format("WARNING: {} of {} times of passes were rejected; the first: {}",
                                loop.rejected_passes, loop.passes, loop.rejection));
  }
  if (loop.overrun_frames > 0) {
    notes.push_back(
        fmt::format("WARNING: in {} of {} frames the passes together took longer than the frame "
                    "around them, by "
                    "up to {:.2g}%: passes overlapped or the clock is wrong",
                    loop.overrun_frames, loop.frames, 100.0 * loop.largest_overrun));
  }
  return notes;
}

}  // namespace occlab
