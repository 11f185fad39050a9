#include "harness/measurement_facts.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "harness/metrics/brightness.h"

namespace occlab {

Facts facts_of(const Measurement& measurement) {
  Facts facts;
  const auto add = [&](const char* name, const std::string& value) {
    if (!value.empty()) facts.emplace_back(name, value);
  };
  add("experiment", measurement.experiment);
  add("scene", measurement.scene);
  add("view", measurement.view);
  add("resolution", measurement.resolution);
  add("probe", measurement.probe);
  add("method", measurement.method);
  facts.insert(facts.end(), measurement.parameters.begin(), measurement.parameters.end());
  return facts;
}

std::string fact(const Facts& facts, const std::string& name) {
  const auto found = std::ranges::find(facts, name, &Facts::value_type::first);
  return found == facts.end() ? "" : found->second;
}

std::string facts_key(const Facts& facts) {
  // Two signs that no name or value holds: the ASCII separators of units and records.
  std::string key;
  for (const auto& [name, value] : facts) {
    key.append(name).append(1, '\x1f').append(value).append(1, '\x1e');
  }
  return key;
}

bool is_time(const Measurement& measurement) {
  return measurement.metric.starts_with("time_ms.") ||
         measurement.metric.starts_with("time_ratio.");
}

bool is_exponent(const Measurement& measurement) {
  return measurement.metric.starts_with("time_exponent.");
}

bool is_over_seeds(const Measurement& measurement) {
  constexpr std::array<std::string_view, 4> metrics = {"noise", "bias", "bias_squared", "mse"};
  return std::ranges::find(metrics, measurement.metric) != metrics.end();
}

bool is_spectrum(const Measurement& measurement) {
  return measurement.metric.starts_with("noise_spectrum.");
}

std::optional<ComparedMetric> compared_metric(const std::string& metric) {
  for (const auto& [middle, ratio] : {std::pair<std::string_view, bool>{"_ratio.", true},
                                      std::pair<std::string_view, bool>{"_difference.", false}}) {
    const std::size_t dot = metric.find(middle);
    if (dot == std::string::npos) continue;
    const std::size_t first = dot + middle.size();
    const std::size_t slash = metric.find('/', first);
    if (slash == std::string::npos) continue;
    return ComparedMetric{metric.substr(0, dot), metric.substr(first, slash - first),
                          metric.substr(slash + 1), ratio};
  }
  return std::nullopt;
}

bool is_budget(const Measurement& measurement) {
  return measurement.metric.starts_with("budget_") || measurement.metric.starts_with("failure_");
}

bool is_of_reference(const Measurement& measurement) {
  return measurement.metric.starts_with("reference_");
}

bool is_brightness(const Measurement& measurement) {
  return is_brightness_metric(measurement.metric);
}

bool is_accuracy(const Measurement& measurement) {
  return !is_time(measurement) && !is_exponent(measurement) && !is_over_seeds(measurement) &&
         !is_spectrum(measurement) && !is_brightness(measurement) && !is_budget(measurement) &&
         !is_of_reference(measurement) && !compared_metric(measurement.metric);
}

bool comparable(const Measurement& a, const Measurement& b) {
  if (a.method == b.method || a.experiment != b.experiment || a.scene != b.scene ||
      a.view != b.view || a.resolution != b.resolution || a.probe != b.probe) {
    return false;
  }
  return std::ranges::all_of(a.parameters, [&](const auto& parameter) {
    const std::string* const other = find_parameter(b, parameter.first);
    return other == nullptr || *other == parameter.second;
  });
}

}  // namespace occlab
