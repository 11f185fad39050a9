#include "harness/claims/claim_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace occlab {
namespace {

using nlohmann::json;

constexpr Alignment left = Alignment::left;
constexpr Alignment right = Alignment::right;

std::string holds_cell(const JudgedClaim& judged) {
  if (judged.cases.empty()) return "";
  return fmt::format("{} of {}", judged.holding(), judged.cases.size());
}

std::string range(const Interval& interval) {
  return fmt::format("[{:.4g}, {:.4g}]", interval.low, interval.high);
}

/// One case, whole.
std::string evidence_of(const CaseEvidence& evidence) {
  std::string text;
  if (evidence.estimate && evidence.interval) {
    text = fmt::format("{:.4g} {}", evidence.estimate->value, range(*evidence.interval));
    if (evidence.outcome != CaseOutcome::holds) {
      text += fmt::format(", {}", to_string(evidence.outcome));
    }
  }
  if (evidence.value && evidence.value_interval) {
    text += fmt::format("{}{:.4g} {}, published {:g}{}{}", text.empty() ? "" : "; ",
                        evidence.value->value, range(*evidence.value_interval), *evidence.published,
                        evidence.value_remark.empty() ? "" : ": ", evidence.value_remark);
  }
  return text.empty() ? evidence.reason : text;
}

/// Several cases in short: the table of the evidence has them all.
std::string summary_of(const std::vector<CaseEvidence>& cases) {
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  for (const CaseEvidence& evidence : cases) {
    const auto& estimate = evidence.estimate ? evidence.estimate : evidence.value;
    if (!estimate) continue;
    lowest = std::min(lowest, estimate->value);
    highest = std::max(highest, estimate->value);
  }
  std::string text = fmt::format("{:.4g} to {:.4g}", lowest, highest);
  for (const CaseOutcome outcome : {CaseOutcome::contradicted, CaseOutcome::unresolved}) {
    const auto count = std::ranges::count(cases, outcome, &CaseEvidence::outcome);
    if (count > 0) text += fmt::format("; {} {}", count, to_string(outcome));
  }
  if (cases.front().published) {
    text += fmt::format("; {} of {} in value",
                        std::ranges::count_if(cases, &CaseEvidence::in_value), cases.size());
  }
  return text;
}

std::string evidence_of(const JudgedClaim& judged) {
  if (!judged.reason.empty()) return judged.reason;
  return judged.cases.size() == 1 ? evidence_of(judged.cases.front()) : summary_of(judged.cases);
}

std::string statement_of(const Claim& claim) {
  if (!claim.statement.empty()) return claim.statement;
  return claim.value.empty() ? "" : "value of " + claim.value;
}

std::vector<std::string> verdict_notes(const JudgedClaims& claims) {
  return {
      claims_summary(claims),
      fmt::format(
          "Reproduced as an ordering: the statement holds in all its cases. {} statements were "
          "tested together: with probability {:g}% at most is any false one of them called "
          "reproduced (intersection-union tests within a claim, Holm's correction over the claims; "
          "equivalences and ranges by two one-sided tests). Intervals are at the confidence at "
          "which the claim was judged",
          claims.family, 100.0 * claims.level),
      "Reproduced in value: all published numbers lie within the 95% intervals, or as near to them "
      "as the claim's tolerance says, and the intervals are narrower than its precision. Not "
      "corrected: each true value is missed in 5% of the runs",
      "Not reproduced: contradicted (the interval is outside of what is claimed) or unresolved "
      "(neither in nor out). All of it is about other seeds or repetitions of these scenes on this "
      "device"};
}

Table verdict_table(const JudgedClaims& claims) {
  Table table{.name = "claims",
              .title = "Claims of the papers",
              .columns = {{"claim", "", left},
                          {"verdict", "", left},
                          {"holds in", "", left},
                          {"what", "", left},
                          {"evidence", "", left},
                          {"statement", "", left},
                          {"paper", "", left},
                          {"place", "", left}},
              .rows = {},
              .notes = verdict_notes(claims)};
  for (const JudgedClaim& judged : claims.all) {
    const Claim& claim = *judged.claim;
    table.rows.push_back({claim.id, std::string(to_string(judged.verdict)), holds_cell(judged),
                          claim.text, evidence_of(judged), statement_of(claim), claim.paper,
                          claim.place});
  }
  return table;
}

TableCell number(double value, const std::optional<Interval>& interval) {
  TableNumber cell{value, {}, {}};
  if (interval) {
    cell.lower = interval->low;
    cell.upper = interval->high;
  }
  return cell;
}

std::string outcome_text(const CaseEvidence& evidence) {
  std::string text(to_string(evidence.outcome));
  const bool too_few = evidence.estimate && evidence.interval &&
                       evidence.estimate->smallest_p > 1.0 - evidence.interval->confidence;
  if (evidence.outcome == CaseOutcome::unresolved && too_few) {
    text += fmt::format(": {} give no p-value below {:.2g}", evidence.estimate->how,
                        evidence.estimate->smallest_p);
  }
  return text;
}

void add_evidence(Table& table, const std::string& id, const CaseEvidence& evidence) {
  const auto row = [&](const std::string& quantity, TableCell value, std::string accepted,
                       std::string outcome, const ClaimEstimate& estimate, double confidence) {
    table.rows.push_back({id, evidence.label, quantity, std::move(value), std::move(accepted),
                          std::move(outcome), TableNumber{100.0 * confidence, {}, {}}, estimate.how,
                          estimate.folder});
  };
  if (evidence.estimate && evidence.interval) {
    row(evidence.quantity, number(evidence.estimate->value, evidence.interval), evidence.accepted,
        outcome_text(evidence), *evidence.estimate, evidence.interval->confidence);
  }
  if (evidence.value) {
    row(evidence.value_quantity, number(evidence.value->value, evidence.value_interval),
        fmt::format("published {:g}", *evidence.published),
        evidence.in_value ? "in value" : evidence.value_remark, *evidence.value,
        evidence.value_interval->confidence);
  }
}

Table evidence_table(const JudgedClaims& claims) {
  Table table{.name = "claims_evidence",
              .title = "The evidence, case by case",
              .columns = {{"claim", "", left},
                          {"case", "", left},
                          {"quantity", "", left},
                          {"measured", "", right},
                          {"accepted", "", left},
                          {"outcome", "", left},
                          {"confidence", "%", right},
                          {"from", "", left},
                          {"results", "", left}},
              .rows = {},
              .notes = {}};
  for (const JudgedClaim& judged : claims.all) {
    for (const CaseEvidence& evidence : judged.cases) {
      add_evidence(table, judged.claim->id, evidence);
    }
  }
  return table;
}

Table contradiction_table(const ClaimFile& file) {
  Table table{.name = "contradictions",
              .title = "Contradictions within the papers",
              .columns = {{"id", "", left},
                          {"paper", "", left},
                          {"place", "", left},
                          {"what", "", left},
                          {"our reading", "", left}},
              .rows = {},
              .notes = {}};
  for (const Contradiction& found : file.contradictions) {
    table.rows.push_back({found.id, found.paper, found.place, found.text, found.reading});
  }
  return table;
}

/// Infinity has no place in JSON.
json number_or_text(double value) {
  if (std::isfinite(value)) return value;
  return value > 0 ? "inf" : "-inf";
}

json interval_json(const Interval& interval) {
  return {{"low", number_or_text(interval.low)},
          {"high", number_or_text(interval.high)},
          {"confidence", interval.confidence}};
}

json estimate_json(const ClaimEstimate& estimate, const Interval& interval) {
  return {{"value", estimate.value},  {"interval", interval_json(interval)},
          {"n", estimate.n},          {"from", estimate.how},
          {"unit", estimate.unit},    {"results", estimate.folder},
          {"device", estimate.device}};
}

json case_json(const CaseEvidence& evidence) {
  json object = {{"case", evidence.label}};
  if (!evidence.reason.empty()) object["reason"] = evidence.reason;
  if (evidence.estimate && evidence.interval) {
    object["statement"] = estimate_json(*evidence.estimate, *evidence.interval);
    object["statement"]["quantity"] = evidence.quantity;
    object["statement"]["difference"] = evidence.estimate->difference;
    object["statement"]["accepted"] = evidence.accepted;
    object["statement"]["outcome"] = to_string(evidence.outcome);
  }
  if (evidence.value && evidence.value_interval) {
    object["value"] = estimate_json(*evidence.value, *evidence.value_interval);
    object["value"]["quantity"] = evidence.value_quantity;
    object["value"]["published"] = *evidence.published;
    object["value"]["in_value"] = evidence.in_value;
    object["value"]["remark"] = evidence.value_remark;
  }
  return object;
}

}  // namespace

std::vector<Table> claim_tables(const ClaimFile& file, const JudgedClaims& claims) {
  std::vector<Table> tables = {verdict_table(claims), evidence_table(claims),
                               contradiction_table(file)};
  std::erase_if(tables, [](const Table& table) { return table.rows.empty(); });
  return tables;
}

json claims_json(const ClaimFile& file, const JudgedClaims& claims) {
  json list = json::array();
  for (const JudgedClaim& judged : claims.all) {
    const Claim& claim = *judged.claim;
    json cases = json::array();
    for (const CaseEvidence& evidence : judged.cases) cases.push_back(case_json(evidence));
    list.push_back({{"id", claim.id},
                    {"paper", claim.paper},
                    {"place", claim.place},
                    {"text", claim.text},
                    {"statement", claim.statement},
                    {"value", claim.value},
                    {"verdict", to_string(judged.verdict)},
                    {"reason", judged.reason},
                    {"holds", judged.holding()},
                    {"adjusted_p", judged.adjusted_p ? json(*judged.adjusted_p) : json()},
                    {"cases", cases}});
  }
  json contradictions = json::array();
  for (const Contradiction& found : file.contradictions) {
    contradictions.push_back({{"id", found.id},
                              {"paper", found.paper},
                              {"place", found.place},
                              {"text", found.text},
                              {"reading", found.reading}});
  }
  return {{"claims", list},
          {"contradictions", contradictions},
          {"tested", claims.family},
          {"false_alarm_rate", claims.level}};
}

std::string claims_summary(const JudgedClaims& claims) {
  std::string text = fmt::format("{} claims", claims.all.size());
  for (const ClaimVerdict verdict : {ClaimVerdict::value, ClaimVerdict::ordering,
                                     ClaimVerdict::not_reproduced, ClaimVerdict::untestable}) {
    const auto count = std::ranges::count(claims.all, verdict, &JudgedClaim::verdict);
    text += fmt::format("{} {} {}", verdict == ClaimVerdict::value ? ":" : ",", count,
                        to_string(verdict));
  }
  return text;
}

}  // namespace occlab
