#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "harness/claims/statement.h"
#include "harness/measurements.h"
#include "harness/paired_bootstrap.h"
#include "harness/statistics.h"

namespace occlab {

/// The measurements of one results folder.
struct MeasuredFolder {
  std::string name;  ///< as it was given
  std::vector<Measurement> rows;
};

/// What is known of a claim's quantity. Where `reason` is not empty, nothing is, and it says why.
/// Its functions need the estimator that made it.
struct ClaimEstimate {
  std::string reason;
  bool difference = false;  ///< of two terms; otherwise their ratio, above 0
  double value = 0.0;
  long n = 0;               ///< seeds or repetitions
  double smallest_p = 0.0;  ///< that so few seeds can give
  std::string unit;
  std::string how;     ///< "8 paired seeds"
  std::string folder;  ///< what it was measured in
  std::string device;
  /// Two-sided, of the true quantity being `bound`.
  std::function<double(double bound)> p_value;
  /// The values that a test at 1 - confidence does not reject.
  std::function<Interval(double confidence)> interval;
};

/// Estimates quantities from stored rows, and keeps what the bootstrap needs between them.
///
/// - Accuracies: the logarithm of the quantity for every seed, and the paired bootstrap of
///   paired_bootstrap.h; the value is a geometric mean over the seeds.
/// - Noise, times and exponents come with intervals of their own. Pairs that were measured as such
///   (`noise_ratio.A/B`, `time_ratio.PASS` against the baseline) are used where there are any. Of
///   several pairs or single terms the standard errors of the logarithms are added, not their
///   squares: how the errors depend on one another is not stored, and this is not too little for
///   any dependence. A time in ms has the standard error of a median of normal values, from its
///   quartiles.
/// - bias_squared: the stored difference with Student's interval.
class ClaimEstimator {
 public:
  explicit ClaimEstimator(const std::vector<MeasuredFolder>& folders) : folders_(&folders) {}

  /// Throws InputError where a term fits several groups of rows.
  ClaimEstimate estimate(const ClaimQuantity& quantity);

 private:
  const PairedBootstrap& bootstrap(std::size_t seeds);

  const std::vector<MeasuredFolder>* folders_;
  std::map<std::size_t, PairedBootstrap> bootstraps_;
};

}  // namespace occlab
