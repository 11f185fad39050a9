#pragma once

#include <functional>
#include <string>

#include "renderers/gl/program.h"

namespace occlab {

/// What measures a pass: the GPU's own clock (GL_TIME_ELAPSED), or wall clock between two glFinish.
enum class Clock { gpu_query, wall };

/// Which clock can be believed on this device, and what showed it.
struct ClockCalibration {
  Clock clock = Clock::wall;
  double query_ms = 0.0;  ///< of the calibration pass
  double wall_ms = 0.0;
  std::string verdict;  ///< one sentence with both numbers
};

/// Times a pass of known length with both clocks, several times. The query is used only where it is
/// positive and within 10% of the wall clock every time (llvmpipe reports 0.8 ms for 451 ms).
ClockCalibration calibrate_clock(ProgramCache& programs);

/// Milliseconds that `run` takes on the device, everything before it finished first. Throws
/// DeviceError if the query gives an impossible value after all.
double time_ms(Clock clock, const std::function<void()>& run);

std::string to_string(Clock clock);

}  // namespace occlab
