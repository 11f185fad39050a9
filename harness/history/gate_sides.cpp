#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>

#include "harness/history/gate.h"
#include "renderers/scene/error.h"

namespace occlab::history {
namespace {

using nlohmann::json;

/// The hashes of an input's files by what the runs call them; a run of several benches names each.
using Files = std::map<std::string, std::set<std::string>>;

void add_file(const json& bench, const char* input, const char* name, Files& files) {
  const json found = bench.value(input, json::object());
  if (!found.is_object() || !found.contains("sha256")) return;
  files[found.value(name, "")].insert(found["sha256"].get<std::string>());
}

Files files_of(const GateSide& side, const char* input, const char* name) {
  Files files;
  for (const RunData& data : side.runs) {
    const json& run = data.facts.run;
    if (!run.is_object()) continue;
    add_file(run, input, name, files);
    for (const json& bench : run.value("benches", json::array())) {
      add_file(bench, input, name, files);
    }
  }
  return files;
}

std::string hashes_text(const std::set<std::string>& hashes) {
  std::vector<std::string> texts;
  for (const std::string& hash : hashes) texts.push_back(hash.substr(0, 12));
  return fmt::format("{}", fmt::join(texts, " and "));
}

/// Inputs of another name make other series.
void compare_inputs(const GateSide& before, const GateSide& after, GateReport& report) {
  for (const auto& [input, name] :
       {std::pair("scene", "name"), std::pair("probe", "description")}) {
    const Files old_files = files_of(before, input, name);
    for (const auto& [called, hashes] : files_of(after, input, name)) {
      const auto old = old_files.find(called);
      if (old == old_files.end()) continue;
      std::set<std::string> all = hashes;
      all.insert(old->second.begin(), old->second.end());
      if (all.size() == 1) continue;
      report.inputs.push_back(fmt::format("the {}'s file is another: SHA-256 {}, before {}", input,
                                          hashes_text(hashes), hashes_text(old->second)));
    }
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
std::size_t count_new(const GateSide& before, const GateSide& after) {
  const auto keys = [](const GateSide& side) {
    std::set<std::string> all;
    for (const RunData& run : side.runs) {
      for (const SeriesValues& values : run.series) {
        all.insert(series_key_on_any_device(values.series));
      }
    }
    return all;
  };
  const std::set<std::string> known = keys(before);
  const std::set<std::string> found = keys(after);
  return std::size_t(
      std::ranges::count_if(found, [&](const std::string& key) { return !known.contains(key); }));
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
  return (!settings.allow_changed_inputs && !report.inputs.empty()) ||
         std::ranges::any_of(report.findings,
                             [&](const Finding& finding) { return is_failure(finding, settings); });
}

}  // namespace

bool is_failure(const Finding& finding, const GateSettings& settings) {
  switch (finding.outcome) {
    case Outcome::worse:
    case Outcome::changed:
      return true;
    case Outcome::missing:
      return !settings.allow_missing;
    case Outcome::unsure:
      return settings.strict;
    default:
      return false;
  }
}

void describe_sides(const GateSide& before_side, const GateSide& after_side,
                    const GateSettings& settings, GateReport& report) {
  const RunData& before = before_side.runs.front();
  const RunData& after = after_side.runs.front();
  compare_inputs(before_side, after_side, report);
  if (!settings.allow_changed_inputs && !report.inputs.empty()) {
    report.notes.emplace_back(
        "With other inputs the numbers are of another picture; --allow-changed-inputs compares "
        "them all the same");
  }
  for (const GateSide* side : {&before_side, &after_side}) {
    for (const RunData& run : side->runs) {
      for (const std::string& left_out : run.left_out) {
        report.notes.push_back(fmt::format("{}: {}", run.name, left_out));
      }
    }
  }
  if (before.facts.device != after.facts.device) {
    report.notes.push_back(
        fmt::format("Other device: '{}', before '{}'. Accuracies are compared "
                    "all the same, times are not",
                    after.facts.device, before.facts.device));
  }
  if (const std::size_t added = count_new(before_side, after_side)) {
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
