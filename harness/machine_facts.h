#pragma once

#include <string>

namespace occlab {

/// As the system names it, "unknown" where it does not.
std::string cpu_model();

/// The load average of the last minute; negative where the system has none.
double load_average();

/// Threads of this process that rasterise: those that llvmpipe has named so. 0 on other devices.
int rasteriser_threads();

}  // namespace occlab
