#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

namespace occlab {

/// A confidence interval. `confidence` is the one it has, which for an interval between order
/// statistics may differ from the one that was asked for.
struct Interval {
  double low = 0.0;
  double high = 0.0;
  double confidence = 0.0;
  bool contains(double value) const { return low <= value && value <= high; }
};

// All functions throw InputError for empty or non-finite samples, for samples of unequal length
// where pairs are asked for, and for probabilities outside their range.

/// Quantile of type 7 (Hyndman and Fan 1996; the default of R and NumPy): linear between the order
/// statistics around (n - 1) p. `probability` in [0, 1].
double quantile(std::span<const double> sample, double probability);
double median(std::span<const double> sample);

struct Quartiles {
  double lower = 0.0;
  double median = 0.0;
  double upper = 0.0;
};
Quartiles quartiles(std::span<const double> sample);

double mean(std::span<const double> sample);
/// Unbiased variance, divided by n - 1; needs n >= 2.
double variance(std::span<const double> sample);

/// Standard normal distribution. The quantile is -inf at 0 and +inf at 1.
double normal_cdf(double z);
double normal_quantile(double probability);

/// Student's t distribution with `degrees` > 0 degrees of freedom.
double student_cdf(double t, double degrees);
double student_quantile(double probability, double degrees);

/// Half of Student's interval of a mean; needs two values or more.
double student_half_width(std::span<const double> sample, double confidence = 0.95);

/// Deterministic uniform integers in [0, count), the same on every platform and library:
/// std::uniform_int_distribution is not specified to that extent. 0 < count < 2^32; the bias of
/// count / 2^32 is far below what resampling can see.
class PortableRandom {
 public:
  explicit PortableRandom(std::uint64_t seed) : engine_(seed) {}
  std::size_t index(std::size_t count) {
    return static_cast<std::size_t>(((engine_() >> 32) * static_cast<std::uint64_t>(count)) >> 32);
  }

 private:
  std::mt19937_64 engine_;
};

struct Resampling {
  double confidence = 0.95;
  int resamples = 2000;
  std::uint64_t seed = 1;
};

/// Median of the ratios a_i / b_i of pairs; all b_i must be non-zero.
double median_ratio(std::span<const double> a, std::span<const double> b);

/// Percentile bootstrap interval (Efron 1979) of median_ratio: pairs are drawn together.
/// The median of few values can only land on few places, so that the interval is too short for
/// small n: its coverage at a nominal 95% is 87.5% for n = 7 (continuous, independent ratios) and
/// 93% for n = 31. Prefer median_ratio_interval for so few.
Interval bootstrap_median_ratio(std::span<const double> a, std::span<const double> b,
                                const Resampling& resampling = {});

/// Interval between order statistics of the ratios a_i / b_i: distribution-free, its coverage of
/// the population's median is exact and at least `confidence` wherever n allows it (n >= 6 for
/// 95%); for smaller n it is the range of the sample and `Interval::confidence` says what that is
/// worth. (Thompson 1936; the inverted sign test.)
Interval median_ratio_interval(std::span<const double> a, std::span<const double> b,
                               double confidence = 0.95);

/// Student's interval of mean(a_i - b_i); exact for normal differences; needs n >= 2. Where they
/// may be skewed see paired_bootstrap.h.
Interval mean_difference_interval(std::span<const double> a, std::span<const double> b,
                                  double confidence = 0.95);

/// The level each of `tests` independent tests must have so that all of them together raise a false
/// alarm with probability `family_level`: 1 - (1 - family_level)^(1/tests) (Sidak 1967).
double sidak_level(double family_level, int tests);

/// Two-sided z-test of an estimate against its expectation.
struct ZTest {
  double z = 0.0;        ///< (estimate - expected) / standard_error
  double p_value = 0.0;  ///< of |z| under a standard normal
  double critical_z = 0.0;
  bool passes = false;  ///< |z| <= critical_z; false where anything is NaN
};

/// One of `tests` tests that together raise a false alarm with probability `family_level`.
/// A standard error of 0 passes only where estimate == expected.
ZTest z_test(double estimate, double expected, double standard_error, double family_level,
             int tests = 1);

/// One of several tests after Holm's step-down correction.
struct HolmTest {
  double adjusted_p = 1.0;  ///< at most the family's level exactly where `rejected`
  bool rejected = false;
  /// The level this test was held to: level / (m - rank + 1) for the rejected, level / (m - R) for
  /// all others, R being the number of the rejected. An interval of confidence 1 - level excludes
  /// the tested value exactly where it is rejected.
  double level = 0.0;
};

/// Holm 1979, "A simple sequentially rejective multiple test procedure": with whatever dependence,
/// the probability of any wrong rejection is at most `family_level`. In the order of `p_values`.
/// Throws InputError for p-values outside [0, 1] and unless 0 < family_level < 1.
std::vector<HolmTest> holm(std::span<const double> p_values, double family_level);

/// A Student interval of n - 1 degrees of freedom taken apart: what its test gives, and what it is
/// at another confidence.
struct StudentEstimate {
  double value = 0.0;
  double standard_error = 0.0;  ///< above 0
  double degrees = 1.0;

  /// Two-sided, of the true value being `hypothesis`.
  double p_value(double hypothesis) const;
  Interval interval(double confidence) const;
};
/// `half_width` > 0 at `confidence`; n >= 2. InputError otherwise.
StudentEstimate student_estimate(double value, double half_width, long n, double confidence = 0.95);

/// Delete-one jackknife (Quenouille 1956, Tukey 1958): the standard error of a statistic from its n
/// values with one observation left out; needs n >= 2.
double jackknife_standard_error(std::span<const double> without_one);

}  // namespace occlab
