#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "harness/config.h"
#include "harness/measurements.h"
#include "harness/workbench.h"

namespace occlab {

/// Times of all variants of an experiment, and what one needs to believe them.
struct TimingResult {
  std::vector<Measurement> measurements;  ///< time_ms.PASS and time_ratio.PASS, tables.h
  nlohmann::json context;                 ///< clock, device, CPU, threads, load, drift, stop reason
};

/// Times plan_timing(experiment) on a workbench: shaders and buffers are warmed up apart; within a
/// repetition the variants run in random order; ratios to the baseline pair what ran in the same
/// repetition. Goes on until every 95% interval of a ratio is within 2% or the budget ends.
/// Intervals are those between order statistics (statistics.h): with the few repetitions affordable
/// here a bootstrap of the median would be too short. `identity` fills what the rows share.
TimingResult time_methods(const Experiment& experiment, Workbench& bench,
                          const Measurement& identity);

}  // namespace occlab
