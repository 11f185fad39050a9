#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "renderers/gl/timer.h"

namespace occlab {

// The order, the pairing and the end of repeated timings. Knows no device: what is timed and the
// clock that ends it are handed in.

/// What one frame took.
struct FrameTimes {
  std::vector<std::pair<std::string, PassTime>> passes;
  double wall_ms = 0.0;  ///< of the whole frame, by wall clock
};

struct TimingTask {
  std::size_t baseline = 0;  ///< the task whose times are its denominators, perhaps itself
  std::function<FrameTimes()> run;
};

struct TimingLimits {
  int repetitions = 7;  ///< at least
  double budget_seconds = 60.0;
};

/// The repetitions end where every 95% interval of a ratio is at most so wide, relative to the
/// ratio.
inline constexpr double wanted_interval_width = 0.02;

/// Beyond this the machine is said to have changed during the timing.
inline constexpr double tolerated_drift = 0.05;

/// The pass names that the loop adds: the whole frame, and what of it lies in no pass.
inline constexpr std::string_view frame_pass = "frame";
inline constexpr std::string_view rest_pass = "rest";

/// One value a repetition; NaN: none that could be believed.
struct PassSeries {
  std::string pass;
  std::vector<double> ms;
};

struct TaskTimes {
  std::vector<PassSeries> passes;  ///< those of the frame in their order, `frame`, `rest`

  /// nullptr if there is no such pass.
  const std::vector<double>* find(std::string_view pass) const;
};

/// Pairs of one repetition, both believed: a / b.
std::vector<double> paired_ratios_of(const std::vector<double>& a, const std::vector<double>& b);

/// What is neither NaN.
std::vector<double> believed(const std::vector<double>& values);

struct LoopResult {
  std::vector<TaskTimes> tasks;
  int repetitions = 0;
  double seconds = 0.0;
  /// Of the interval of an occlusion pass's ratio (of the frame's, where there is no such pass) to
  /// its baseline, relative to the ratio; infinite where a ratio could not be had.
  double widest_interval = 0.0;
  bool within = false;  ///< widest_interval <= wanted_interval_width; else the budget ended it
  /// Median over the tasks of the median frame of the last third over that of the first.
  double drift = 1.0;
  int passes = 0;           ///< that were timed
  int rejected_passes = 0;  ///< their values count for nothing
  std::string rejection;    ///< of the first of them
  int frames = 0;
  int overrun_frames = 0;        ///< whose passes together took longer than the frame around them
  double largest_overrun = 0.0;  ///< their sum over the frame, less 1
};

/// Runs every task once, uncounted, then in random order once a repetition, those with one baseline
/// next to each other, until every interval is tight, but at least limits.repetitions times, or
/// until the budget ends. `seconds` is the time
/// since some start; `after_repetition` hears of each (its number, the widest interval). What
/// throws in a task ends it all.
LoopResult run_timing_loop(const std::vector<TimingTask>& tasks, const TimingLimits& limits,
                           const std::function<double()>& seconds,
                           const std::function<void(int, double)>& after_repetition);

}  // namespace occlab
