// What series.h has of metrics: which way is better, which change matters.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "harness/comparisons.h"
#include "harness/history/series.h"
#include "harness/metrics/metrics.h"
#include "renderers/scene/error.h"

namespace occlab::history {

Direction direction_of(const std::string& metric) {
  if (metric.starts_with("time_") || metric.starts_with("budget_rms.")) return Direction::lower;
  const std::optional<bool> lower = lower_is_better(metric);
  if (!lower) return Direction::none;
  return *lower ? Direction::lower : Direction::higher;
}

std::string to_string(Direction direction) {
  if (direction == Direction::none) return "none";
  return direction == Direction::lower ? "lower" : "higher";
}

MetricClass class_of(const std::string& metric) {
  if (metric.starts_with("time_")) return MetricClass::time;
  const auto declared = std::ranges::find(metrics(), metric, &MetricInfo::name);
  if (declared != metrics().end() && declared->unit == "dB") return MetricClass::decibel;
  return direction_of(metric) == Direction::higher ? MetricClass::similarity : MetricClass::error;
}

double MinimumEffects::of(MetricClass metric_class) const {
  switch (metric_class) {
    case MetricClass::similarity:
      return similarity;
    case MetricClass::decibel:
      return decibel;
    case MetricClass::time:
      return time;
    default:
      return error;
  }
}

void MinimumEffects::set(const std::string& name, double value, const std::string& where) {
  const std::vector<std::string> names = {"error", "similarity", "decibel", "time"};
  const std::array<double*, 4> places = {&error, &similarity, &decibel, &time};
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) {
    throw InputError(
        fmt::format("{}: unknown class '{}'{}", where, name, accepted_words(name, names)));
  }
  if (!(value > 0.0) || !std::isfinite(value)) {
    throw InputError(
        fmt::format("{}: found {} for {}; accepted is a number above 0", where, value, name));
  }
  *places[std::size_t(found - names.begin())] = value;
}

bool is_relative(MetricClass metric_class) {
  return metric_class == MetricClass::error || metric_class == MetricClass::time;
}

bool has_history(const Measurement& row) {
  return !compared_metric(row.metric) && row.metric.find("_spectrum.") == std::string::npos;
}

namespace {

constexpr std::string_view reference_interval = "reference_interval";

/// Equal for what has the same reference.
std::string place_of(const Series& series) {
  std::string place;
  for (const std::string& fact : {series.experiment, series.scene, series.view, series.resolution,
                                  series.probe, series.unit, series.device}) {
    place += fmt::format("{}:{};", fact.size(), fact);
  }
  return place;
}

}  // namespace

void NoiseFloors::add(const Series& series, std::optional<double> value) {
  if (series.metric == reference_interval && value) floors_[place_of(series)] = *value;
}

std::optional<double> NoiseFloors::of(const Series& series) const {
  if (direction_of(series.metric) != Direction::lower || series.metric.starts_with("time_")) {
    return std::nullopt;
  }
  const auto found = floors_.find(place_of(series));
  return found == floors_.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace occlab::history
