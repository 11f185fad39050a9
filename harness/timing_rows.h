#pragma once

#include <string>
#include <utility>
#include <vector>

#include "harness/measurements.h"
#include "harness/timing_loop.h"

namespace occlab {

// From repeated times to measurements.

/// A timed task, and what its rows say of it.
struct TimedSeries {
  Measurement facts;  ///< everything but metric, unit, value, interval, n and reason
  TaskTimes times;
  TaskTimes baseline;
  std::string rejection;  ///< why values are missing, where any are
  /// The axes that it is a point of, and where on each.
  std::vector<std::pair<std::string, double>> axes;
};

/// `time_ms.PASS` (median and quartiles) of every pass, and `time_ratio.PASS` (median of the pairs'
/// ratios, interpolated_median_interval) of the method's own passes and of the frame. Where fewer
/// than three values can be believed there is a reason instead.
std::vector<Measurement> time_rows(const TimedSeries& series);

/// The exponents of all series' axes, and what is to be said of them.
struct Exponents {
  /// `time_exponent.AXIS.PASS` of every method, axis and pass but the rest, by fit_power_law; n is
  /// the number of points it was fitted to. Facts are those of `shared`, and the method.
  std::vector<Measurement> rows;
  std::vector<std::string> notes;  ///< which are no power law even so
};
Exponents fit_exponents(const std::vector<TimedSeries>& all, const Measurement& shared);

/// What the result of a loop says of itself, for the notes under the table: how long and why it
/// ended, drift, rejected values, passes longer than their frame.
std::vector<std::string> loop_notes(const LoopResult& loop, const TimingLimits& limits);

}  // namespace occlab
