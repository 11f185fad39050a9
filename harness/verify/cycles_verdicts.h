#pragma once

#include <string>

#include "harness/verify/check.h"
#include "harness/verify/cycles_comparison.h"

namespace occlab {

/// Probability that a comparison of equal renderers counts too many pixels beyond 3 sigma.
inline constexpr double share_false_alarms = 1e-6;

/// What two renderings of one integral must satisfy; subject "cycles", case `name`:
///   - the 95% interval of every block's relative difference lies within 0.5%: "could not resolve"
///     if it reaches beyond on noise alone;
///   - no more pixels differ by 3 sigma than noise gives, at share_false_alarms;
///   - the 95% interval of the whole picture's relative difference lies within 0.5%.
/// Throws InputError where no block has pixels enough.
Checks judge_comparison(const RendererComparison& comparison, const std::string& name);

}  // namespace occlab
