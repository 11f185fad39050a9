#pragma once

#include <string>

#include "harness/bench_plan.h"
#include "harness/config.h"
#include "harness/measurements.h"
#include "harness/workbench.h"

namespace occlab {

/// What all measurements of a bench share: experiment, scene, view, resolution, probe and device.
Measurement shared_facts(const BenchPlan& bench, const DeviceInfo& device);
Measurement shared_facts(const Experiment& experiment, const Workbench& bench);

/// The same for all runs whose times may stand for each other. Times depend on the code, the device
/// and what is asked for, not on the cells.
std::string timing_key_of(const Experiment& experiment, const BenchFacts& facts);

}  // namespace occlab
