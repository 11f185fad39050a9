#include "harness/claims/record.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "harness/claims/claim_terms.h"
#include "harness/files.h"
#include "renderers/scene/error.h"
#include "renderers/scene/limited_json.h"

namespace occlab {
namespace {

using nlohmann::json;

std::string text_of(const Claim& claim) {
  std::string text = claim.statement;
  if (!claim.value.empty()) text += fmt::format("{}{}", text.empty() ? "" : "; ", claim.value);
  for (const ClaimCase& one : claim.cases) {
    if (!one.label.empty()) text += "; " + one.label;
    if (one.published) text += fmt::format(": {:g}", *one.published);
  }
  return text;
}

const ClaimEstimate* first_estimate(const JudgedClaim& judged) {
  for (const CaseEvidence& evidence : judged.cases) {
    if (evidence.estimate) return &*evidence.estimate;
    if (evidence.value) return &*evidence.value;
  }
  return nullptr;
}

std::string device_of(const JudgedClaim& judged) {
  const ClaimEstimate* const estimate = first_estimate(judged);
  return estimate ? estimate->device : "";
}

bool is_about_times(const Claim& claim) {
  if (claim.cases.empty()) return false;
  const ClaimCase& first = claim.cases.front();
  const ClaimQuantity& quantity = first.statement ? first.statement->quantity : *first.value;
  const ClaimMetric kind = claim_metric(quantity.factors.front().term.metric);
  return kind == ClaimMetric::time || kind == ClaimMetric::exponent;
}

const json& require(const json& object, const std::string& key, const std::string& where) {
  if (object.is_object() && object.contains(key)) return object[key];
  throw InputError(fmt::format("{}: key '{}': missing; was it written by 'occlab claims --accept'?",
                               where, key));
}

std::string require_text(const json& object, const std::string& key, const std::string& where) {
  const json& value = require(object, key, where);
  if (value.is_string()) return value.get<std::string>();
  throw InputError(
      fmt::format("{}: key '{}': found {}; accepted is a text", where, key, value.dump()));
}

const JudgedClaim* find_claim(const JudgedClaims& claims, const std::string& id) {
  const auto found = std::ranges::find_if(
      claims.all, [&](const JudgedClaim& judged) { return judged.claim->id == id; });
  return found == claims.all.end() ? nullptr : &*found;
}

/// "2 of 9 cases contradicted, 1 unresolved".
std::string what_fails(const JudgedClaim& judged) {
  if (judged.claim->statement.empty()) {
    return fmt::format("{} of {} values", judged.cases.size() - judged.holding(),
                       judged.cases.size());
  }
  const auto count = [&](CaseOutcome outcome) {
    return std::ranges::count(judged.cases, outcome, &CaseEvidence::outcome);
  };
  return fmt::format("{} of {} cases contradicted, {} unresolved", count(CaseOutcome::contradicted),
                     judged.cases.size(), count(CaseOutcome::unresolved));
}

/// Adds what there is to say of one claim of the record.
void compare_one(const std::string& id, const RecordedClaim& before, const JudgedClaim& now,
                 RecordComparison& result) {
  const auto remark = [&](const std::string& text) { result.remarks.push_back(id + ": " + text); };
  if (now.verdict == before.verdict) return;
  if (now.verdict == ClaimVerdict::untestable) {
    result.untested += is_reproduced(before.verdict) ? 1 : 0;
    return;
  }
  if (before.statement != text_of(*now.claim)) {
    return remark(fmt::format("is {}; another statement was {}", to_string(now.verdict),
                              to_string(before.verdict)));
  }
  if (is_about_times(*now.claim) && before.device != device_of(now)) {
    return remark(fmt::format("is {}; on another device ({}) it was {}", to_string(now.verdict),
                              before.device, to_string(before.verdict)));
  }
  if (is_reproduced(before.verdict) && !is_reproduced(now.verdict)) {
    result.lost.push_back(fmt::format("{}: was {}, and is not any more: {}", id,
                                      to_string(before.verdict), what_fails(now)));
    return;
  }
  remark(fmt::format("was {}, is {}", to_string(before.verdict), to_string(now.verdict)));
}

}  // namespace

ClaimRecord read_record(const std::filesystem::path& path) {
  ClaimRecord record;
  if (!std::filesystem::exists(path)) return record;
  const std::string name = path.string();
  const json stored = parse_limited_json(read_text(path), name);
  if (require(stored, "format", name) != 1) {
    throw InputError(
        fmt::format("{}: key 'format': found {}; accepted is 1", name, stored["format"].dump()));
  }
  record.commit = require_text(stored, "commit", name);
  const json& claims = require(stored, "claims", name);
  if (!claims.is_object()) {
    throw InputError(fmt::format("{}: key 'claims': accepted is an object", name));
  }
  for (const auto& [id, claim] : claims.items()) {
    const std::string where = fmt::format("{}: claims.{}", name, id);
    record.claims[id] = {parse_verdict(require_text(claim, "verdict", where), where),
                         require_text(claim, "statement", where),
                         require_text(claim, "device", where)};
  }
  return record;
}

void write_record(const std::filesystem::path& path, const ClaimRecord& record) {
  json claims = json::object();
  for (const auto& [id, claim] : record.claims) {
    claims[id] = {{"verdict", to_string(claim.verdict)},
                  {"statement", claim.statement},
                  {"device", claim.device}};
  }
  const json stored = {{"format", 1}, {"commit", record.commit}, {"claims", claims}};
  write_text_atomically(path, stored.dump(2) + "\n");
}

ClaimRecord accept(const ClaimRecord& before, const JudgedClaims& claims,
                   const std::string& commit) {
  ClaimRecord record;
  record.commit = commit;
  for (const JudgedClaim& judged : claims.all) {
    const std::string& id = judged.claim->id;
    if (judged.verdict != ClaimVerdict::untestable) {
      record.claims[id] = {judged.verdict, text_of(*judged.claim), device_of(judged)};
    } else if (const auto kept = before.claims.find(id); kept != before.claims.end()) {
      record.claims[id] = kept->second;
    }
  }
  return record;
}

RecordComparison compare(const ClaimRecord& record, const JudgedClaims& claims) {
  RecordComparison result;
  for (const auto& [id, before] : record.claims) {
    if (const JudgedClaim* const now = find_claim(claims, id)) {
      compare_one(id, before, *now, result);
    } else if (is_reproduced(before.verdict)) {
      result.lost.push_back(fmt::format("{}: was {}, and no claim has this id any more", id,
                                        to_string(before.verdict)));
    }
  }
  return result;
}

}  // namespace occlab
