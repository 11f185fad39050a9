#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "harness/statistics.h"

namespace occlab {

/// What is known of the mean of paired differences.
struct PairedDifference {
  double mean = 0.0;
  double standard_error = 0.0;
  double p_value = 1.0;  ///< two-sided, of a true mean of 0
};

/// Studentised paired bootstrap, symmetric about the mean (Efron 1979; Hall 1988, "On symmetric
/// bootstrap confidence intervals"): the resampled |t| = |mean* - mean| / standard error* takes the
/// place of Student's distribution.
///
/// Pairs are drawn together, so that what both methods share cancels. Over several views, views and
/// seeds are drawn independently of one another (the pigeonhole bootstrap, Owen 2007): a seed means
/// the same samples in every view, so that seeds are crossed with views, not nested in them, and
/// resampling only one of the two would miss the other's share of the variance. The squared
/// standard error is var(means of the views)/V + var(means of the seeds)/K, which counts the
/// interaction of the two twice and so errs on the safe side.
///
/// Up to 8 seeds of one view every resample there is is enumerated with its probability: no random
/// numbers, no smallest step but the one that the seeds have. Otherwise `Resampling::resamples` are
/// drawn once, from Resampling::seed, for all differences of this shape, and the p-value counts the
/// sample itself as one more (Davison and Hinkley 1997, section 4.2).
///
/// Coverage of nominal 95% intervals of one view's seeds, from 400000 simulated samples each, and
/// of what is not used:
///
///     seeds                             5      8     16     32
///     normal differences            97.7%  96.4%  95.6%  95.2%
///     exponential differences       94.1%  93.0%  93.6%  94.4%
///     log-normal, sigma 1           90.1%  88.2%  89.6%  91.3%
///     percentile bootstrap, normal    84%    88%    92%  93.5%
///     Student's t, exponential        88%    89%    91%    93%
///
/// At the levels of a large family Student's t errs far more on skewed differences: for 8
/// exponential ones it rejects the truth at 0.1% in 1.9% of the samples, this in 0.55%.
class PairedBootstrap {
 public:
  /// Throws InputError unless seeds >= 2, views >= 1 (both below 2^16) and resamples >= 1.
  explicit PairedBootstrap(std::size_t seeds, std::size_t views = 1,
                           const Resampling& resampling = {});

  /// `differences`: those of all seeds of the first view, then of the second, ... Throws InputError
  /// for another number of them and for values that are not finite.
  PairedDifference test(std::span<const double> differences) const;

  /// The values that the test at level 1 - confidence does not reject: 0 is outside exactly where
  /// the p-value is at most 1 - confidence. Infinite where so few seeds support no such confidence.
  Interval interval(std::span<const double> differences, double confidence) const;

  /// No difference, however clear, has a smaller p-value: the probability that a resample holds one
  /// seed only (K^(1-K) for K <= 8 seeds of one view), plus the step of the drawn ones.
  double smallest_p() const { return smallest_p_; }

 private:
  void enumerate();
  void draw(int resamples, std::uint64_t seed);
  void add_resample(std::span<const int> seeds, std::span<const int> views, double probability);
  void require_shape(std::span<const double> differences) const;
  /// t^2 of every resample.
  std::vector<double> studentised_squares(std::span<const double> centred) const;

  std::size_t seeds_;
  std::size_t views_;
  std::vector<std::vector<std::uint16_t>> seed_counts_;  // [seed][resample]
  std::vector<std::vector<std::uint16_t>> view_counts_;  // [view][resample]
  std::vector<double> probabilities_;                    // of the resamples
  double beyond_ = 0.0;  // probability of a t beyond all that were drawn
  double smallest_p_ = 0.0;
};

}  // namespace occlab
