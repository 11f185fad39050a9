#pragma once

#include <string>

#include "harness/verify/check.h"
#include "harness/verify/cycles_comparison.h"

namespace occlab {

/// What two renderings of one integral must satisfy; subject "cycles", case `name`:
///   - the 95% interval of every block's relative difference lies within 0.5%: "could not resolve"
///     if it reaches beyond on noise alone;
///   - no more pixels differ by 3 sigma than noise gives, at a false-alarm rate of 1e-6;
///   - the 95% interval of the whole picture's relative difference lies within 0.5%.
/// Throws InputError where no block has pixels enough.
Checks judge_comparison(const RendererComparison& comparison, const std::string& name);

}  // namespace occlab
