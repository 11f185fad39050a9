#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "harness/history/gate.h"
#include "harness/tables.h"

namespace occlab::history {

/// The findings as a table, the worst first; those that are the same only where `all`.
Table gate_table(const GateReport& report, bool all);

/// JUnit XML: a test case a series; worse, changed and (unless allowed) missing are failures,
/// unsure is skipped. Other inputs and a comparison of nothing are failures of their own.
std::string gate_junit(const GateReport& report, const GateSettings& settings);

/// For a pull request: the verdict, what needs looking at, and all the rest folded.
std::string gate_markdown(const GateReport& report, const GateSettings& settings);

nlohmann::json gate_json(const GateReport& report, const GateSettings& settings);

/// "+3.1%" or "+0.12": an effect as its metric is compared.
std::string effect_text(double effect, bool relative);

}  // namespace occlab::history
