#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "renderers/gl/program.h"

namespace occlab {

/// What measures a pass: the GPU's own clock (GL_TIME_ELAPSED), or wall clock between two glFinish.
enum class Clock { gpu_query, wall };
std::string to_string(Clock clock);

/// What a timer query gave: 64 bits, read with their sign, so that a negative time shows as one.
struct QueryReading {
  std::int64_t nanoseconds = 0;
  int counter_bits = 64;  ///< of the device's counter; it starts again after 2^bits ns
};

/// Why a reading cannot be the time of a pass that took `wall_ms` from a glFinish before it to one
/// after it: negative, zero, longer than the wall time, less than half of it where that is above
/// 10 ms (below, what starting a pass takes may be as much), or from a counter that may have
/// started again meanwhile. "" if it can be.
std::string why_rejected(const QueryReading& reading, double wall_ms);

/// One pass by one clock.
struct PassTime {
  std::optional<double> ms;  ///< none: `rejected` says why
  double wall_ms = 0.0;      ///< around the pass, whatever the clock
  std::string rejected;
};

/// Times a pass on the device, everything before it finished first.
PassTime time_pass(Clock clock, const std::function<void()>& run);

/// One pass timed by both clocks.
struct ClockComparison {
  QueryReading query;
  double wall_ms = 0.0;
};

/// Which clock can be believed on this device, and what showed it.
struct ClockCalibration {
  Clock clock = Clock::wall;
  double query_ms = 0.0;  ///< of the pass where the clocks differ most
  double wall_ms = 0.0;
  std::string verdict;  ///< one sentence with both numbers
};

/// The query is believed where no reading is rejected and all are within 10% of the wall clock, and
/// never of a software rasteriser: its clocks agree by chance on a loaded machine, and two runs of
/// one experiment must have one clock. `comparisons` is not empty.
ClockCalibration judge_clocks(const std::vector<ClockComparison>& comparisons, bool software);

/// Times a pass of known length (20 ms or more) with both clocks, several times, and judges
/// (llvmpipe reports 0.8 ms for 451 ms).
ClockCalibration calibrate_clock(ProgramCache& programs, bool software);

}  // namespace occlab
