#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "harness/comparisons.h"
#include "harness/statistics.h"

namespace occlab {

/// A comparison before Holm's correction. Without a p-value it is not tested.
struct ComparisonTest {
  Comparison comparison;
  std::optional<double> p_value;
  double smallest_p = 0.0;  ///< that these seeds can give
  std::function<Interval(double confidence)> interval;
};

/// The comparison of two rows of a table: their names, facts and keys.
Comparison new_comparison(const Measurement& a, const Measurement& b);

/// The test of a stored estimate with its Student interval of n - 1 degrees of freedom: of a ratio
/// on a logarithmic scale.
ComparisonTest test_estimate(Comparison comparison, const Measurement& row);

/// Holm's correction over all that have a p-value, and the interval that belongs to it. A verdict
/// `equal` that is there already stays.
Comparisons decide(std::vector<ComparisonTest> tests);

}  // namespace occlab
