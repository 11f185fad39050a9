#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "harness/history/gate.h"

namespace occlab::history {

/// Reads `level` and the table [minimum_effect] of a TOML file. Throws InputError for any other
/// key.
void read_gate_settings(const std::string& path, GateSettings& gate);

/// Of the command line, "CLASS=VALUE" each. Throws InputError.
void apply_minimum_effects(const std::vector<std::string>& settings, MinimumEffects& minimum);

/// What a baseline that is accepted all the same is remembered with (Baseline::findings).
nlohmann::json accepted_findings(const GateReport& report);

}  // namespace occlab::history
