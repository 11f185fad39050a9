#include "harness/history/series.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "harness/files.h"
#include "harness/measurement_facts.h"

namespace occlab::history {
namespace {

/// What a series is of, besides the method and its parameters.
constexpr std::array<std::pair<const char*, std::string Series::*>, 4> places = {
    {{"scene", &Series::scene},
     {"view", &Series::view},
     {"resolution", &Series::resolution},
     {"probe", &Series::probe}}};

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
  for (const auto& [name, place] : places) {
    if (std::ranges::find(shown, name) == shown.end()) continue;
    details += fmt::format("{}{}", details.empty() ? "" : ", ", series.*place);
  }
  return details.empty() ? text : fmt::format("{} ({})", text, details);
}

std::vector<std::string> differing_parameters(const std::vector<const Series*>& all) {
  std::vector<std::string> names;
  std::map<std::pair<std::string, std::string>, std::string> first;  // method and name: value
  std::map<std::string, std::set<std::string>> found;
  for (const Series* series : all) {
    for (const auto& [name, value] : series->parameters) {
      const auto [known, added] = first.try_emplace({series->method, name}, value);
      const bool differs = !added && known->second != value;
      if (differs && std::ranges::find(names, name) == names.end()) names.push_back(name);
    }
    for (const auto& [name, place] : places) found[name].insert(series->*place);
  }
  for (const auto& [name, place] : places) {
    if (found[name].size() > 1) names.emplace_back(name);
  }
  return names;
}

}  // namespace occlab::history
