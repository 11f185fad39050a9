#pragma once

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "harness/claims/verdicts.h"
#include "planted_measurements.h"

namespace occlab {

// Measurements whose ratios are known, and claims about them.

inline Measurement claim_row(const std::string& method, const std::string& metric) {
  Measurement row;
  row.experiment = "x";
  row.scene = "gallery";
  row.view = "main";
  row.resolution = "64x36";
  row.probe = "cathedral";
  row.method = method;
  if (method != "rtdo") row.parameters = {{"samples", "32"}};
  row.seed = "all";
  row.stage = metric.starts_with("time") ? "" : "filtered";
  row.metric = metric;
  row.device = "llvmpipe (software)";
  return row;
}

/// A value for every seed; NaN stands for one that could not be measured.
inline void plant(std::vector<Measurement>& rows, const std::string& method,
                  const std::string& metric, const Values& values) {
  add(rows, claim_row(method, metric), values);
}

/// A value over 8 seeds with its 95% interval.
inline void plant_estimate(std::vector<Measurement>& rows, const std::string& method,
                           const std::string& metric, double value, double lower, double upper,
                           std::vector<std::string> cells) {
  Measurement row = claim_row(method, metric);
  row.value = value;
  row.lower = lower;
  row.upper = upper;
  row.n = 8;
  row.cells = std::move(cells);
  rows.push_back(row);
}

/// A time with narrow quartiles, and its ratio to the baseline, from 20 repetitions.
inline void plant_time(std::vector<Measurement>& rows, const std::string& method, double ms,
                       double ratio, double lower, double upper) {
  Measurement row = claim_row(method, "time_ms.occlusion");
  row.value = ms;
  row.lower = 0.99 * ms;
  row.upper = 1.01 * ms;
  row.n = 20;
  rows.push_back(row);
  row.metric = "time_ratio.occlusion";
  row.value = ratio;
  row.lower = lower;
  row.upper = upper;
  rows.push_back(row);
}

inline Claim statement_claim(const std::string& text) {
  std::set<std::string> used;
  Claim claim;
  claim.id = "planted";
  claim.statement = text;
  claim.experiment = "x";
  claim.cases.push_back({"", parse_statement(text, {}, used), {}, {}});
  return claim;
}

inline Claim value_claim(const std::string& text, double published) {
  std::set<std::string> used;
  Claim claim;
  claim.id = "planted";
  claim.value = text;
  claim.experiment = "x";
  claim.cases.push_back({"", {}, parse_quantity(text, {}, used), published});
  return claim;
}

inline ClaimFile file_with(std::vector<Claim> claims) {
  ClaimFile file;
  file.commands["x"] = "occlab run x.toml";
  file.claims = std::move(claims);
  return file;
}

/// The claim alone; its `claim` is only valid until the next call.
inline JudgedClaim judge(const Claim& claim, const std::vector<Measurement>& rows) {
  static ClaimFile file;
  file = file_with({claim});
  const std::vector<MeasuredFolder> folders = {{"planted", rows}};
  ClaimEstimator estimator(folders);
  return judge_claims(file, estimator).all.front();
}

inline JudgedClaim judge_one(const std::string& statement, const std::vector<Measurement>& rows) {
  return judge(statement_claim(statement), rows);
}

}  // namespace occlab
