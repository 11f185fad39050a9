#include "harness/history/series.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "harness/comparisons.h"
#include "harness/files.h"
#include "harness/measurement_facts.h"
#include "harness/metrics/metrics.h"
#include "renderers/scene/error.h"

namespace occlab::history {
namespace {

constexpr std::string_view reference_interval = "reference_interval";

/// Equal exactly where the facts are: each text with its length.
std::string joined(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += fmt::format("{}:{};", text.size(), text);
  return all;
}

std::string key_with(const Series& series, const std::string& device) {
  std::vector<std::string> texts = {
      series.experiment, series.scene, series.view,   series.resolution, series.probe,
      series.method,     series.stage, series.metric, series.unit,       device};
  auto parameters = series.parameters;
  std::ranges::sort(parameters);
  for (const auto& [name, value] : parameters) {
    texts.push_back(name);
    texts.push_back(value);
  }
  return sha256_text(joined(texts)).substr(0, 16);
}

std::string place_of(const Series& series) {
  return joined({series.experiment, series.scene, series.view, series.resolution, series.probe,
                 series.unit, series.device});
}

}  // namespace

Series series_of(const Measurement& row, const std::string& machine) {
  Series series{row.experiment, row.scene, row.view,   row.resolution, row.probe, row.method,
                row.parameters, row.stage, row.metric, row.unit,       row.device};
  if (is_time(row)) {
    if (!row.clock.empty()) series.device += ", " + row.clock;
    if (!machine.empty()) series.device += ", " + machine;
  }
  return series;
}

std::string series_key(const Series& series) { return key_with(series, series.device); }

std::string series_key_on_any_device(const Series& series) { return key_with(series, ""); }

std::string series_label(const Series& series, const std::vector<std::string>& shown) {
  std::string text = fmt::format("{} {}", series.method, series.metric);
  if (!series.stage.empty()) text += " " + series.stage;
  std::string details;
  for (const auto& [name, value] : series.parameters) {
    if (std::ranges::find(shown, name) == shown.end()) continue;
    details += fmt::format("{}{} {}", details.empty() ? "" : ", ", name, value);
  }
  if (std::ranges::find(shown, "view") != shown.end()) {
    details += fmt::format("{}{}", details.empty() ? "" : ", ", series.view);
  }
  return details.empty() ? text : fmt::format("{} ({})", text, details);
}

std::vector<std::string> differing_parameters(const std::vector<const Series*>& all) {
  std::vector<std::string> names;
  std::map<std::pair<std::string, std::string>, std::string> first;  // method and name: value
  std::vector<std::string> views;
  for (const Series* series : all) {
    for (const auto& [name, value] : series->parameters) {
      const auto [known, added] = first.try_emplace({series->method, name}, value);
      const bool differs = !added && known->second != value;
      if (differs && std::ranges::find(names, name) == names.end()) names.push_back(name);
    }
    if (std::ranges::find(views, series->view) == views.end()) views.push_back(series->view);
  }
  if (views.size() > 1) names.emplace_back("view");
  return names;
}

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
