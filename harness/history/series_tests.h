#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "harness/history/series.h"
#include "harness/paired_bootstrap.h"
#include "harness/statistics.h"

namespace occlab::history {

/// How much a series changed from one run to another, before any correction. The effect is a share
/// of the baseline where the metric's class is relative, and a difference otherwise.
struct EffectTest {
  bool identical = false;         ///< bit for bit, for all seeds
  std::optional<double> effect;   ///< none: `reason` says why
  std::optional<double> p_value;  ///< of no change; none: cannot be tested, `reason` says why
  double smallest_p = 0.0;        ///< that so few seeds can give
  std::function<Interval(double confidence)> interval;
  std::string how;     ///< "8 paired seeds"
  std::string reason;  ///< why there is no test
};

/// One bootstrap for every number of seeds: made once, as resamples are the same for all series.
class SeedTests {
 public:
  /// `family`: about how many series are compared, which decides on the number of resamples.
  explicit SeedTests(std::size_t family);

  /// An accuracy. Seeds that both runs have are paired (paired_bootstrap.h); where fewer than two
  /// are common, the means of all seeds are compared by Welch's test, whose intervals are wider.
  EffectTest compare(const SeriesValues& before, const SeriesValues& after) const;

 private:
  EffectTest paired(const std::vector<double>& before, const std::vector<double>& after,
                    bool relative) const;
  int resamples_;
  mutable std::map<std::size_t, std::shared_ptr<const PairedBootstrap>> made_;
};

/// A number over all seeds with its Student interval, such as the noise: Welch's test of the ratio
/// on a logarithmic scale. What both runs share does not cancel: errs on the side of no change.
EffectTest compare_estimates(const SeriesValues& before, const SeriesValues& after);

/// Times of repeated runs, the baseline's and the new ones', on a logarithmic scale. How much a
/// time varies between runs of the same code is taken from all groups of such runs together
/// (`others`: those of other commits); the interval within one run says nothing of it. Without any
/// repeated run there is no test. Student's t with the degrees of freedom of the pooled variance.
EffectTest compare_times(const std::vector<double>& before, const std::vector<double>& after,
                         const std::vector<std::vector<double>>& others);

}  // namespace occlab::history
