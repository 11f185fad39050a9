#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "harness/config.h"
#include "harness/measurements.h"
#include "harness/workbench.h"

namespace occlab {

/// Times of all cells of plan_timing, and what one needs to believe them.
struct TimingResult {
  /// time_ms.PASS, time_ratio.PASS (tables.h); where axes are varied one by one, also
  /// time_exponent.AXIS.PASS. Where triangles or threads are axes, they are among the parameters.
  std::vector<Measurement> measurements;
  /// For run.json: clock, machine, repetitions, end, drift and what was rejected; `notes` says the
  /// same in sentences for the table, with warnings.
  nlohmann::json context;
};

/// Throws InputError where timing.threads is an axis: a workbench that is there has its threads.
void require_own_threads(const Experiment& experiment);

/// Times the plan on a workbench: shaders and buffers are warmed up apart; within a repetition the
/// cells run in random order; ratios to the baseline pair what ran in the same repetition
/// (timing_loop.h). `shared` fills what the rows share. Throws InputError where timing.threads is
/// an axis: a workbench has its threads.
TimingResult time_methods(const Experiment& experiment, Workbench& bench,
                          const Measurement& shared);

/// The same with a workbench of its own for each number of threads, one after the other; they are
/// not paired. The workbench of a single number is that of time_methods. `described` hears of
/// each workbench before it is timed. Throws InputError where threads are an axis and the device is
/// no software rasteriser.
TimingResult time_experiment(const Experiment& experiment, const std::string& device,
                             const std::function<void(const Workbench&)>& described);

}  // namespace occlab
