#include "harness/claims/verdicts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "harness/claims/claim_terms.h"
#include "harness/statistics.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double value_confidence = 0.95;

constexpr std::array<std::pair<ClaimVerdict, std::string_view>, 4> verdict_names = {
    {{ClaimVerdict::value, "reproduced in value"},
     {ClaimVerdict::ordering, "reproduced as an ordering"},
     {ClaimVerdict::not_reproduced, "not reproduced"},
     {ClaimVerdict::untestable, "not testable here"}}};

/// Where the quantity has to be. A difference is compared with 0 where a ratio is with 1.
struct Bounds {
  double low = 0.0;
  double high = infinity;
  bool has_low = false;
  bool has_high = false;
};

Bounds bounds_of(const ClaimStatement& statement, bool difference) {
  Bounds bounds{statement.low, statement.high, statement.low > 0.0, statement.high < infinity};
  if (difference) {
    bounds.low = bounds.has_low ? 0.0 : -infinity;
    bounds.high = bounds.has_high ? 0.0 : infinity;
  }
  return bounds;
}

std::string to_string(const Bounds& bounds) {
  if (!bounds.has_high) return fmt::format("> {:.4g}", bounds.low);
  if (!bounds.has_low) return fmt::format("< {:.4g}", bounds.high);
  return fmt::format("{:.4g} to {:.4g}", bounds.low, bounds.high);
}

/// Two-sided of the nearer bound being true; 1 outside of the bounds.
double p_value(const ClaimEstimate& estimate, const Bounds& bounds) {
  if (!(bounds.low < estimate.value && estimate.value < bounds.high)) return 1.0;
  double p = 0.0;
  if (bounds.has_low) p = std::max(p, estimate.p_value(bounds.low));
  if (bounds.has_high) p = std::max(p, estimate.p_value(bounds.high));
  return std::min(p, 1.0);
}

CaseOutcome outcome_of(const Interval& interval, const Bounds& bounds) {
  if (bounds.low < interval.low && interval.high < bounds.high) return CaseOutcome::holds;
  if (interval.high < bounds.low || interval.low > bounds.high) return CaseOutcome::contradicted;
  return CaseOutcome::unresolved;
}

std::string software_reason(const ClaimEstimate& estimate) {
  return fmt::format("a claim about hardware, and the times are those of a software rasteriser: {}",
                     estimate.device);
}

bool is_software(const ClaimEstimate& estimate) {
  return estimate.device.find("(software)") != std::string::npos;
}

/// Estimates of one case, not judged yet.
CaseEvidence gather(const Claim& claim, const ClaimCase& one, ClaimEstimator& estimator) {
  CaseEvidence evidence;
  evidence.label = one.label;
  const auto take = [&](const ClaimQuantity& quantity) {
    ClaimEstimate estimate = estimator.estimate(quantity);
    if (estimate.reason.empty() && claim.hardware && is_software(estimate)) {
      estimate.reason = software_reason(estimate);
    }
    if (!estimate.reason.empty()) evidence.reason = estimate.reason;
    return estimate;
  };
  if (one.statement) {
    evidence.estimate = take(one.statement->quantity);
    evidence.quantity = to_string(one.statement->quantity);
    if (evidence.estimate->difference) {
      evidence.quantity = fmt::format("{} - {}", to_string(one.statement->quantity.factors[0].term),
                                      to_string(one.statement->quantity.factors[1].term));
    }
    evidence.accepted = to_string(bounds_of(*one.statement, evidence.estimate->difference));
    if (!evidence.estimate->reason.empty()) evidence.estimate.reset();
  }
  if (one.value) {
    evidence.value_quantity = to_string(*one.value);
    evidence.published = one.published;
    evidence.value = take(*one.value);
    if (!evidence.value->reason.empty()) evidence.value.reset();
  }
  return evidence;
}

/// `share` of the published number: how far it is from the interval, and how wide that is.
void judge_value(const Claim& claim, CaseEvidence& evidence) {
  if (!evidence.value) return;
  const Interval interval = evidence.value->interval(value_confidence);
  const double published = *evidence.published;
  evidence.value_interval = interval;
  const double distance = std::max({0.0, interval.low - published, published - interval.high});
  const double half_width = 0.5 * (interval.high - interval.low);
  if (distance > claim.tolerance * published) {
    evidence.value_remark = "not the published value";
  } else if (!(half_width <= claim.precision * published)) {
    evidence.value_remark = "too uncertain to tell";
  } else {
    evidence.in_value = true;
  }
}

bool is_missing(const CaseEvidence& evidence) { return !evidence.reason.empty(); }

/// Intervals and outcomes of the statements, at one confidence for all cases of a claim.
void judge_statements(JudgedClaim& judged, double confidence) {
  for (std::size_t i = 0; i < judged.cases.size(); ++i) {
    CaseEvidence& evidence = judged.cases[i];
    if (!evidence.estimate) continue;
    evidence.interval = evidence.estimate->interval(confidence);
    evidence.outcome = outcome_of(*evidence.interval, bounds_of(*judged.claim->cases[i].statement,
                                                                evidence.estimate->difference));
  }
}

/// The largest p-value of the cases; nothing where one is missing or there is no statement.
std::optional<double> claim_p_value(const JudgedClaim& judged) {
  if (judged.cases.empty() || judged.claim->statement.empty()) return std::nullopt;
  double p = 0.0;
  for (std::size_t i = 0; i < judged.cases.size(); ++i) {
    const CaseEvidence& evidence = judged.cases[i];
    if (!evidence.estimate) return std::nullopt;
    const Bounds bounds =
        bounds_of(*judged.claim->cases[i].statement, evidence.estimate->difference);
    p = std::max(p, p_value(*evidence.estimate, bounds));
  }
  return p;
}

std::string missing_reason(const JudgedClaim& judged, const ClaimFile& file) {
  const auto first = std::ranges::find_if(judged.cases, is_missing);
  if (!first->reason.starts_with("not measured: ")) return first->reason;
  return fmt::format("{}; made by '{}'", first->reason, file.commands.at(judged.claim->experiment));
}

ClaimVerdict verdict_of(const JudgedClaim& judged) {
  const Claim& claim = *judged.claim;
  const bool has_statement = !claim.statement.empty();
  const bool failed = std::ranges::any_of(judged.cases, [&](const CaseEvidence& evidence) {
    if (is_missing(evidence)) return false;
    return has_statement ? evidence.outcome != CaseOutcome::holds : !evidence.in_value;
  });
  if (failed) return ClaimVerdict::not_reproduced;
  if (std::ranges::any_of(judged.cases, is_missing)) return ClaimVerdict::untestable;
  const bool in_value =
      !claim.value.empty() && std::ranges::all_of(judged.cases, &CaseEvidence::in_value);
  return in_value ? ClaimVerdict::value : ClaimVerdict::ordering;
}

}  // namespace

std::string_view to_string(ClaimVerdict verdict) {
  return std::ranges::find(verdict_names, verdict, [](const auto& v) { return v.first; })->second;
}

ClaimVerdict parse_verdict(std::string_view text, const std::string& where) {
  for (const auto& [verdict, name] : verdict_names) {
    if (name == text) return verdict;
  }
  std::vector<std::string> names;
  for (const auto& [verdict, name] : verdict_names) names.emplace_back(name);
  throw InputError(
      fmt::format("{}: unknown verdict '{}'{}", where, text, accepted_words(text, names)));
}

bool is_reproduced(ClaimVerdict verdict) {
  return verdict == ClaimVerdict::value || verdict == ClaimVerdict::ordering;
}

std::string_view to_string(CaseOutcome outcome) {
  constexpr std::array<std::string_view, 4> names = {"holds", "contradicted", "unresolved",
                                                     "not testable"};
  return names[std::size_t(outcome)];
}

std::size_t JudgedClaim::holding() const {
  const bool by_value = claim->statement.empty();
  return std::size_t(std::ranges::count_if(cases, [&](const CaseEvidence& evidence) {
    return by_value ? evidence.in_value : evidence.outcome == CaseOutcome::holds;
  }));
}

JudgedClaims judge_claims(const ClaimFile& file, ClaimEstimator& estimator) {
  JudgedClaims result;
  result.level = file.level;
  std::vector<double> p_values;
  std::vector<std::size_t> tested;
  for (const Claim& claim : file.claims) {
    JudgedClaim judged;
    judged.claim = &claim;
    for (const ClaimCase& one : claim.cases) {
      judged.cases.push_back(gather(claim, one, estimator));
      judge_value(claim, judged.cases.back());
    }
    if (const std::optional<double> p = claim_p_value(judged)) {
      p_values.push_back(*p);
      tested.push_back(result.all.size());
    }
    result.all.push_back(std::move(judged));
  }
  result.family = tested.size();
  const std::vector<HolmTest> corrected = holm(p_values, file.level);
  for (std::size_t i = 0; i < tested.size(); ++i) {
    JudgedClaim& judged = result.all[tested[i]];
    judged.adjusted_p = corrected[i].adjusted_p;
    // A claim with a stricter level of its own has its share of what Holm's procedure grants.
    judge_statements(judged, 1.0 - corrected[i].level * judged.claim->level / file.level);
  }
  for (JudgedClaim& judged : result.all) {
    if (!judged.claim->untestable.empty()) {
      judged.reason = judged.claim->untestable;
      continue;
    }
    if (!judged.adjusted_p) judge_statements(judged, 1.0 - file.level);  // some cases alone
    judged.verdict = verdict_of(judged);
    if (judged.verdict == ClaimVerdict::untestable) judged.reason = missing_reason(judged, file);
  }
  return result;
}

}  // namespace occlab
