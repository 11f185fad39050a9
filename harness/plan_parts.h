#pragma once

#include <string>
#include <vector>

#include "harness/config.h"

namespace occlab {

// What planning cells and planning times share.

/// The method of a name that load_experiment has checked.
const MethodInfo& planned_method(const std::vector<MethodInfo>& methods, const std::string& name);

/// The defaults, then [parameters] as far as the method declares them.
ParameterSet common_parameters(const Experiment& experiment, const MethodInfo& method);

}  // namespace occlab
