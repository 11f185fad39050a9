#pragma once

#include <optional>
#include <string>
#include <vector>

#include "harness/measurements.h"
#include "harness/published.h"
#include "harness/tables.h"

namespace occlab {

/// What the tables of times need besides the measurements; run.json keeps it.
struct TimingTableSettings {
  std::string baseline;                 ///< the method that ratios are to; empty: no times
  std::string published;                ///< results/published/NAME.csv; empty: none
  std::vector<std::string> notes = {};  ///< of the experiment, the clock and the machine
};

// As all tables (tables.h). They throw InputError where times of several devices or clocks are
// mixed.

/// Median times of each pass with quartiles and the ratios to the baseline, beside the published
/// times of the same method, samples and steps (and resolution, where several were published) and
/// their ratios to `baseline`.
Table timing_table(const std::vector<Measurement>& measurements,
                   const TimingTableSettings& settings,
                   const std::optional<PublishedTimes>& published);

/// For a paper that printed frame rates: whole frames a second and how much lower that is than the
/// baseline's, in percent, beside what was printed and what the printed frame rates give. What was
/// printed of methods that were not timed has no numbers of ours. The notes name where the printed
/// percentages cannot come of the printed frame rates, however those were rounded. Has no row where
/// nothing was timed.
Table frame_rate_table(const std::vector<Measurement>& measurements,
                       const TimingTableSettings& settings, const PublishedTimes& published);

/// `time_exponent.AXIS.PASS`: a row for each axis and method, a column for each pass.
Table scaling_table(const std::vector<Measurement>& measurements);

}  // namespace occlab
