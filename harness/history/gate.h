#pragma once

#include <optional>
#include <string>
#include <vector>

#include "harness/history/run_data.h"
#include "harness/history/series_tests.h"

namespace occlab::history {

enum class Outcome {
  worse,    ///< significant, and at least the minimum effect, in the wrong direction
  changed,  ///< the same of a metric of which occlab does not know what is better
  missing,  ///< the baseline has it, the results do not
  unsure,   ///< neither shown to have changed nor shown to be the same
  better,   ///< as worse, in the right direction
  same,     ///< equal bit for bit, or its whole 95% interval is within the minimum effect
};
std::string to_string(Outcome outcome);

struct GateSettings {
  double level = 0.05;  ///< of any wrong worse, better or changed, all of them together
  MinimumEffects minimum;
  bool absolute_times =
      false;  ///< judge milliseconds too, not only ratios to the timing's baseline
  bool allow_missing = false;
  bool allow_changed_inputs = false;
  bool strict = false;  ///< an unsure one fails, too
};

/// What is compared: one run, and the times of further runs of the same code.
struct GateSide {
  std::vector<RunData> runs;  ///< accuracies: of the first that has the series
};

/// One series of the baseline.
struct Finding {
  Series series;
  Outcome outcome = Outcome::unsure;
  std::optional<double> before;
  std::optional<double> after;
  std::optional<double> effect;  ///< a share where `relative`, else a difference
  std::optional<double> lower;   ///< of its 95% interval; lower and upper come together
  std::optional<double> upper;
  bool relative = true;
  double minimum = 0.0;
  std::optional<double> adjusted_p;  ///< Holm's
  std::optional<double> floor;       ///< the scene's noise floor (NoiseFloors)
  std::string how;                   ///< what was compared
  std::string reason;                ///< of unsure and missing
};

struct GateReport {
  std::string baseline;  ///< name
  std::string results;
  std::string experiment;
  double level = 0.05;
  std::vector<Finding> findings;        ///< the worst first
  std::vector<std::string> inputs;      ///< scene or probe that is another than the baseline's
  std::vector<std::string> notes;       ///< what else a reader has to know
  std::vector<std::string> mismatches;  ///< why nothing could be compared, where nothing was

  std::size_t count(Outcome outcome) const;
  /// Equal bit for bit, or tested.
  std::size_t compared() const;
};

/// Compares every series of the baseline that is judged (FORMAT.md) with that of the results.
/// `other_runs`: groups of runs of other programs, of which the variation of times between runs is
/// learnt; a run that is one of the results' counts once. Accuracies are one family after Holm,
/// times another; with both, each has half the level.
GateReport run_gate(const GateSide& baseline, const GateSide& results,
                    const std::vector<std::vector<RunData>>& other_runs,
                    const GateSettings& settings);

/// Whether it alone makes a check fail.
bool is_failure(const Finding& finding, const GateSettings& settings);

/// Fills inputs, notes and mismatches: what else differs between the two sides.
void describe_sides(const GateSide& before, const GateSide& after, const GateSettings& settings,
                    GateReport& report);

/// 0; 1 where anything is worse, changed or, unless allowed, missing or made of other inputs;
/// 2 where nothing was compared.
int exit_code(const GateReport& report, const GateSettings& settings);

/// One line that says how it went.
std::string summary(const GateReport& report, const GateSettings& settings);

}  // namespace occlab::history
