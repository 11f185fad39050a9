#include "harness/history/gate_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "harness/csv.h"
#include "harness/table_formats.h"

namespace occlab::history {
namespace {

using nlohmann::json;

std::vector<std::string> shown_parameters(const GateReport& report) {
  std::vector<const Series*> series;
  for (const Finding& finding : report.findings) series.push_back(&finding.series);
  return differing_parameters(series);
}

std::string interval_text(const Finding& finding) {
  if (!finding.lower) return "";
  return fmt::format("[{}, {}]", effect_text(*finding.lower, finding.relative),
                     effect_text(*finding.upper, finding.relative));
}

std::string limit_text(const Finding& finding) {
  return finding.relative ? fmt::format("{:g}%", 100.0 * finding.minimum)
                          : fmt::format("{:g}", finding.minimum);
}

TableCell number_or_dash(const std::optional<double>& value, const char* reason) {
  if (value) return TableNumber{*value, std::nullopt, std::nullopt};
  return TableMissing{reason};
}

/// Errors in noise floors: the new one over what the scene allows to tell.
std::optional<double> in_floors(const Finding& finding) {
  if (!finding.floor || !finding.after || !(*finding.floor > 0.0)) return std::nullopt;
  return *finding.after / *finding.floor;
}

std::string how_text(const Finding& finding) {
  if (finding.how.empty() || finding.reason.empty()) return finding.how + finding.reason;
  return finding.how + ": " + finding.reason;
}

std::string xml(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '&':
        safe += "&amp;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        // XML 1.0 has no other control characters, not even escaped.
        safe += static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' ? '?' : c;
    }
  }
  return safe;
}

std::string sentence(const Finding& finding) {
  std::string text = to_string(finding.outcome);
  if (finding.effect) {
    text += fmt::format(" {} {}", effect_text(*finding.effect, finding.relative),
                        interval_text(finding));
  }
  if (finding.adjusted_p) text += fmt::format(", adjusted p {:.2g}", *finding.adjusted_p);
  text += fmt::format(", minimum effect {}", limit_text(finding));
  if (in_floors(finding)) text += fmt::format(", {:.3g} noise floors", *in_floors(finding));
  if (const std::string how = how_text(finding); !how.empty()) text += "; " + how;
  return text;
}

/// Text that Markdown prints as it is.
std::string plain_markdown(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (std::string_view("\\`*_{}[]<>#|").find(c) != std::string_view::npos) escaped += '\\';
    escaped += c == '\n' ? ' ' : c;
  }
  return escaped;
}

json number_json(const std::optional<double>& value) {
  if (!value) return nullptr;
  return std::isfinite(*value) ? json(*value) : json(number_text(*value));
}

}  // namespace

std::string effect_text(double effect, bool relative) {
  if (!std::isfinite(effect)) return effect > 0.0 ? "+inf" : "-inf";
  if (!relative) return fmt::format("{:+.3g}", effect);
  const double percent = 100.0 * effect;
  if (percent == 0.0) return "0%";
  return std::abs(percent) < 99.95 ? fmt::format("{:+.2g}%", percent)
                                   : fmt::format("{:+.0f}%", percent);
}

Table gate_table(const GateReport& report, bool all) {
  Table table{"check", fmt::format("{} against {}", report.results, report.baseline), {}, {}, {}};
  table.columns = {{"verdict", "", Alignment::left}, {"series", "", Alignment::left},
                   {"before", "", Alignment::right}, {"after", "", Alignment::right},
                   {"change", "", Alignment::right}, {"95% interval", "", Alignment::right},
                   {"floors", "", Alignment::right}, {"compared", "", Alignment::left}};
  const std::vector<std::string> shown = shown_parameters(report);
  for (const Finding& finding : report.findings) {
    if (!all && finding.outcome == Outcome::same) continue;
    table.rows.push_back(
        {to_string(finding.outcome), series_label(finding.series, shown),
         number_or_dash(finding.before, "not measured"),
         number_or_dash(finding.after, "not in the results"),
         finding.effect ? effect_text(*finding.effect, finding.relative) : std::string(),
         interval_text(finding),
         in_floors(finding) ? fmt::format("{:.3g}", *in_floors(finding)) : std::string(),
         how_text(finding)});
  }
  table.notes.push_back(fmt::format(
      "WORSE, CHANGED and BETTER: significant (all of them together wrong with a probability of at "
      "most {:g}%, Holm) and at least the minimum effect; SAME: equal bit for bit, or the whole "
      "95% "
      "interval is within it",
      100.0 * report.level));
  if (std::ranges::any_of(report.findings, [](const Finding& f) { return f.floor.has_value(); })) {
    table.notes.emplace_back(
        "floors: the error in noise floors of the scene, the half-width of its reference's own 95% "
        "interval");
  }
  for (const std::string& input : report.inputs) table.notes.push_back("WARNING: " + input);
  for (const std::string& note : report.notes) table.notes.push_back(note);
  return table;
}

std::string gate_junit(const GateReport& report, const GateSettings& settings) {
  const std::vector<std::string> shown = shown_parameters(report);
  std::string cases;
  std::size_t failures = 0;
  std::size_t skipped = 0;
  const auto add = [&](const std::string& place, const std::string& name, const char* kind,
                       const std::string& text) {
    cases += fmt::format("    <testcase classname=\"{}\" name=\"{}\"", xml(place), xml(name));
    failures += std::string_view(kind) == "failure" ? 1 : 0;
    skipped += std::string_view(kind) == "skipped" ? 1 : 0;
    cases += *kind == '\0' ? fmt::format("><system-out>{}</system-out></testcase>\n", xml(text))
                           : fmt::format("><{} message=\"{}\"/></testcase>\n", kind, xml(text));
  };
  std::size_t more = 0;
  if (report.compared() == 0) {
    add(report.experiment, "comparison", "failure", summary(report, settings));
    ++more;
  }
  for (const std::string& input : report.inputs) {
    add(report.experiment, "inputs", settings.allow_changed_inputs ? "" : "failure", input);
    ++more;
  }
  for (const Finding& finding : report.findings) {
    const bool unsure = finding.outcome == Outcome::unsure || finding.outcome == Outcome::missing;
    const char* const kind = is_failure(finding, settings) ? "failure" : unsure ? "skipped" : "";
    add(fmt::format("{}.{}.{}", finding.series.experiment, finding.series.scene,
                    finding.series.view),
        series_label(finding.series, shown), kind, sentence(finding));
  }
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n  <testsuite name=\"occlab {}\" "
      "tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"{}\">\n{}  "
      "</testsuite>\n</testsuites>\n",
      xml(report.experiment), report.findings.size() + more, failures, skipped, cases);
}

std::string gate_markdown(const GateReport& report, const GateSettings& settings) {
  std::string text = fmt::format("### occlab: {}\n\n", plain_markdown(summary(report, settings)));
  const bool open = std::ranges::any_of(
      report.findings, [](const Finding& finding) { return finding.outcome != Outcome::same; });
  if (open) text += format_table(gate_table(report, false), "md") + "\n";
  text += fmt::format("<details><summary>All {} series</summary>\n\n{}\n</details>\n",
                      report.findings.size(), format_table(gate_table(report, true), "md"));
  return text;
}

json gate_json(const GateReport& report, const GateSettings& settings) {
  json findings = json::array();
  for (const Finding& finding : report.findings) {
    json parameters = json::object();
    for (const auto& [name, value] : finding.series.parameters) parameters[name] = value;
    findings.push_back({{"verdict", to_string(finding.outcome)},
                        {"series", series_key(finding.series)},
                        {"experiment", finding.series.experiment},
                        {"scene", finding.series.scene},
                        {"view", finding.series.view},
                        {"resolution", finding.series.resolution},
                        {"probe", finding.series.probe},
                        {"method", finding.series.method},
                        {"parameters", parameters},
                        {"stage", finding.series.stage},
                        {"metric", finding.series.metric},
                        {"unit", finding.series.unit},
                        {"better", to_string(direction_of(finding.series.metric))},
                        {"before", number_json(finding.before)},
                        {"after", number_json(finding.after)},
                        {"effect", number_json(finding.effect)},
                        {"lower", number_json(finding.lower)},
                        {"upper", number_json(finding.upper)},
                        {"relative", finding.relative},
                        {"minimum_effect", finding.minimum},
                        {"adjusted_p", number_json(finding.adjusted_p)},
                        {"noise_floor", number_json(finding.floor)},
                        {"in_noise_floors", number_json(in_floors(finding))},
                        {"compared", finding.how},
                        {"reason", finding.reason}});
  }
  json counts = json::object();
  for (const Outcome outcome : {Outcome::worse, Outcome::changed, Outcome::missing, Outcome::unsure,
                                Outcome::better, Outcome::same}) {
    counts[to_string(outcome)] = report.count(outcome);
  }
  return {{"format", 1},
          {"results", report.results},
          {"baseline", report.baseline},
          {"experiment", report.experiment},
          {"passed", exit_code(report, settings) == 0},
          {"exit_code", exit_code(report, settings)},
          {"summary", summary(report, settings)},
          {"level", report.level},
          {"compared", report.compared()},
          {"counts", counts},
          {"inputs", report.inputs},
          {"notes", report.notes},
          {"mismatches", report.mismatches},
          {"findings", findings}};
}

}  // namespace occlab::history
