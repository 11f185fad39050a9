#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <set>

#include "harness/history/gate.h"
#include "renderers/scene/error.h"

namespace occlab::history {
namespace {

using nlohmann::json;

std::string fact_of(const json& run, const char* object, const char* key) {
  if (!run.is_object() || !run.contains(object) || !run[object].is_object()) return "";
  return run[object].value(key, "");
}

void compare_inputs(const RunData& before, const RunData& after, GateReport& report) {
  for (const char* input : {"scene", "probe"}) {
    const std::string old_hash = fact_of(before.facts.run, input, "sha256");
    const std::string new_hash = fact_of(after.facts.run, input, "sha256");
    if (old_hash.empty() || new_hash.empty() || old_hash == new_hash) continue;
    report.inputs.push_back(fmt::format("the {}'s file is another: SHA-256 {:.12}, before {:.12}",
                                        input, new_hash, old_hash));
  }
}

using Getter = std::function<std::string(const Series&)>;

std::set<std::string> all_of(const RunData& run, const Getter& get) {
  std::set<std::string> values;
  for (const SeriesValues& series : run.series) values.insert(get(series.series));
  values.erase("");
  return values;
}

/// Why no series of the one is one of the other.
std::vector<std::string> differences(const RunData& before, const RunData& after) {
  const std::vector<std::pair<const char*, Getter>> facts = {
      {"experiment", [](const Series& s) { return s.experiment; }},
      {"scene", [](const Series& s) { return s.scene; }},
      {"view", [](const Series& s) { return s.view; }},
      {"resolution", [](const Series& s) { return s.resolution; }},
      {"probe", [](const Series& s) { return s.probe; }},
      {"method", [](const Series& s) { return s.method; }},
      {"metric", [](const Series& s) { return s.metric; }}};
  std::vector<std::string> reasons;
  for (const auto& [name, get] : facts) {
    const std::set<std::string> a = all_of(after, get);
    const std::set<std::string> b = all_of(before, get);
    const bool common = std::ranges::any_of(a, [&](const auto& text) { return b.contains(text); });
    if (common) continue;
    reasons.push_back(fmt::format("{}: '{}' here, '{}' in the baseline", name, fmt::join(a, "', '"),
                                  fmt::join(b, "', '")));
  }
  if (reasons.empty()) reasons.emplace_back("the methods have other parameters, stages or metrics");
  return reasons;
}

/// Series of the results that the baseline does not have.
std::size_t count_new(const RunData& before, const RunData& after) {
  std::set<std::string> known;
  for (const SeriesValues& values : before.series) {
    known.insert(series_key_on_any_device(values.series));
  }
  return std::size_t(std::ranges::count_if(after.series, [&](const SeriesValues& values) {
    return !known.contains(series_key_on_any_device(values.series));
  }));
}

/// Ratios to a baseline method that itself became slower all become better.
void note_baseline_method(GateReport& report) {
  std::size_t better = 0;
  std::size_t all = 0;
  for (const Finding& finding : report.findings) {
    if (!finding.series.metric.starts_with("time_ratio.")) continue;
    ++all;
    better += finding.outcome == Outcome::better ? 1 : 0;
  }
  if (all > 1 && better == all) {
    report.notes.emplace_back(
        "All ratios of times became better: perhaps the method they are ratios to became slower");
  }
}

bool fails(const GateReport& report, const GateSettings& settings) {
  return report.count(Outcome::worse) + report.count(Outcome::changed) > 0 ||
         (!settings.allow_missing && report.count(Outcome::missing) > 0) ||
         (!settings.allow_changed_inputs && !report.inputs.empty()) ||
         (settings.strict && report.count(Outcome::unsure) > 0);
}

}  // namespace

void describe_sides(const RunData& before, const RunData& after, const GateSettings& settings,
                    GateReport& report) {
  compare_inputs(before, after, report);
  if (!settings.allow_changed_inputs && !report.inputs.empty()) {
    report.notes.emplace_back(
        "With other inputs the numbers are of another picture; --allow-changed-inputs compares "
        "them all the same");
  }
  for (const RunData* run : {&before, &after}) {
    for (const std::string& left_out : run->left_out) {
      report.notes.push_back(fmt::format("{}: {}", run->name, left_out));
    }
  }
  if (before.facts.device != after.facts.device) {
    report.notes.push_back(
        fmt::format("Other device: '{}', before '{}'. Accuracies are compared "
                    "all the same, times are not",
                    after.facts.device, before.facts.device));
  }
  if (const std::size_t added = count_new(before, after)) {
    report.notes.push_back(
        fmt::format("{} series are new: the baseline does not have them", added));
  }
  note_baseline_method(report);
  if (report.compared() > 0) return;
  const bool matched = std::ranges::any_of(
      report.findings, [](const Finding& finding) { return finding.after.has_value(); });
  if (!matched) {
    report.mismatches = differences(before, after);
    return;
  }
  std::set<std::string> reasons;
  for (const Finding& finding : report.findings) {
    if (!finding.reason.empty()) reasons.insert(finding.reason);
  }
  report.mismatches.assign(reasons.begin(), reasons.end());
}

int exit_code(const GateReport& report, const GateSettings& settings) {
  if (report.compared() == 0) return exit_bad_input;
  return fails(report, settings) ? exit_check_failed : exit_good;
}

std::string summary(const GateReport& report, const GateSettings& settings) {
  if (report.compared() == 0) {
    return fmt::format("nothing was compared: {}", fmt::join(report.mismatches, "; "));
  }
  std::string text = fails(report, settings) ? "FAILED: " : "passed: ";
  const char* separator = "";
  for (const Outcome outcome : {Outcome::worse, Outcome::changed, Outcome::missing, Outcome::unsure,
                                Outcome::better, Outcome::same}) {
    const std::size_t count = report.count(outcome);
    if (count == 0) continue;
    text += fmt::format("{}{} {}", separator, count, to_string(outcome));
    separator = ", ";
  }
  if (!report.inputs.empty()) text += fmt::format(", {} other inputs", report.inputs.size());
  return text;
}

}  // namespace occlab::history
