#pragma once

#include <nlohmann/json.hpp>

#include "harness/config.h"
#include "harness/workbench.h"

namespace occlab {

/// What run.json says of the experiment and of what made it: the resolved configuration, commit,
/// device, driver, library versions, hashes of the scene and the probe, seeds.
nlohmann::json environment_report(const Experiment& experiment, const Workbench& bench);

}  // namespace occlab
