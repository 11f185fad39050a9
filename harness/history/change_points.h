#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "harness/statistics.h"

namespace occlab::history {

/// A lasting change between two runs of a series.
struct ChangePoint {
  std::size_t first = 0;  ///< index of the first value after the step
  double before = 0.0;    ///< mean of the values since the step before, or since the beginning
  double after = 0.0;     ///< mean of the values up to the next step
  Interval ratio;         ///< 95% of after / before; NaN where that means nothing (signs, zeros)
  double p_value = 1.0;   ///< of no change; 0: the series repeats exactly and then does not
};

struct ChangePointSettings {
  /// Of a step in a series that has none; halves on both sides of a step are tested again.
  double level = 0.01;
  /// A step needs as many values on each side, unless the series repeats exactly.
  std::size_t least = 3;
  int permutations = 1999;
  std::uint64_t seed = 1;
};

/// Steps in the order of the history. Values are finite.
///
/// Where at least half of the values repeat the one before bit for bit (all accuracies do, as equal
/// code draws equal pixels), every change of the value is a step.
///
/// Otherwise binary segmentation: the split with the largest
///     T = sqrt(k (n - k) / n) |mean of the last n - k - mean of the first k|
/// is a step where T is as large in at most `level` of random permutations of the values, and both
/// sides are searched again. Values farther than 5 scaled median absolute deviations from the
/// median are moved to there first, so that one outlier decides nothing. Under no change all orders
/// are equally likely, whatever the distribution: the false-alarm rate is the level, exactly, for
/// values that do not depend on each other. Permutations end early once the level cannot be reached
/// any more. At last every step moves to the best split between its neighbours.
///
/// False alarms and power, from 2000 simulated series of 40 values each
/// (tests/statistical/change_points_test.cpp): see docs/regression.md.
std::vector<ChangePoint> find_change_points(std::span<const double> values,
                                            const ChangePointSettings& settings = {});

}  // namespace occlab::history
