#pragma once

#include <optional>
#include <span>
#include <vector>

#include "harness/statistics.h"

namespace occlab {

/// The interval of a median that the ratios of paired times get: between the interval from order
/// statistics that covers too much and the next one, which covers too little (Hettmansperger and
/// Sheather 1986, "Confidence intervals based on interpolated order statistics"). Below 6 values no
/// order statistics reach 95%: it is the range of the sample, and `Interval::confidence` says what
/// that is worth.
///
/// Why not a bootstrap: worst coverage of nominal 95% intervals over normal and exponential values
/// and normal ones of which a tenth is 10 times as wide, 100000 samples each (the bootstrap 4000):
///
///     values                        6      7      8      9     15     31     63
///     interpolated              95.0%  94.4%  94.5%  95.0%  94.9%  94.9%  94.9%
///     order statistics          96.8%  98.4%  99.2%  96.0%  96.4%  97.0%  95.7%
///     their width over that of
///     the interpolated, at most  1.36   2.08   2.83   1.14   1.14   1.14   1.04
///     percentile bootstrap      92.8%  87.1%  90.9%  92.2%  91.5%  93.2%  93.7%
///
/// Throws InputError for empty or non-finite samples and a confidence outside (0, 1).
Interval interpolated_median_interval(std::span<const double> sample, double confidence = 0.95);

/// y = constant * x^exponent through points whose y was measured again and again.
struct PowerLaw {
  double exponent = 0.0;
  std::optional<Interval> interval;  ///< 95%, Student's over the repetitions; none with only one
  int points = 0;                    ///< of the largest x, those that were used
  bool curved = false;               ///< even these do not lie on a power law
};

/// One x and its y in every repetition; the repetitions of all points belong together.
struct RepeatedPoint {
  double x = 0.0;
  std::vector<double> y;  ///< NaN: not measured
};

/// The slope of log y over log x by least squares, repetition by repetition, and the mean of these
/// slopes: what changes all times of a repetition alike cancels. Where the times are resolved as
/// curved (the mean of the repetitions' quadratic coefficients differs from 0 at 1%) and the slope
/// changes by more than 0.05 from the first point to the last, the smallest x is left out, and
/// again, until this is no longer so or three points are left: the exponent is that of the
/// asymptotic part. Points are sorted by x. Throws InputError for fewer than two points, for x or y
/// that are not positive and finite (y may be NaN), and where two points have the same x. A
/// repetition without all of the points is left out; nullopt if none is whole.
std::optional<PowerLaw> fit_power_law(std::vector<RepeatedPoint> points);

}  // namespace occlab
