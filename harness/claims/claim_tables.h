#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "harness/claims/verdicts.h"
#include "harness/tables.h"

namespace occlab {

/// The verdicts; the evidence, a row for each case; and where the papers contradict themselves.
std::vector<Table> claim_tables(const ClaimFile& file, const JudgedClaims& claims);

/// All of it, for scripts.
nlohmann::json claims_json(const ClaimFile& file, const JudgedClaims& claims);

/// "12 of 40 claims: 1 reproduced in value, ..."
std::string claims_summary(const JudgedClaims& claims);

}  // namespace occlab
