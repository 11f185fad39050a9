#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "harness/statistics.h"
#include "renderers/scene/image.h"

namespace occlab {

/// Renderings of one view by one method that differ in the seed only, gathered one by one.
///
/// Only the foreground's values are kept, as floats: 11 MB for a run of 1280x720 RGB that is all
/// foreground. They are needed, because runs, not pixels, are the independent observations here:
/// all pixels of a run share the same 16 sample sets, so that their errors are correlated across
/// the whole image, and resampling pixels or blocks of them would promise far too short intervals.
class RunStatistics {
 public:
  /// `mask`: one channel, foreground where it exceeds 0.5. InputError when it is empty.
  explicit RunStatistics(const Image& mask);

  /// One more run, of one or three channels of linear values. The order of the runs pairs those of
  /// two methods: add the same seeds in the same order. InputError for a size other than the
  /// mask's or a number of channels other than the first run's. Values that are not finite are
  /// accepted here and make noise_and_bias() report a failure.
  void add(const Image& run);

  int runs() const { return static_cast<int>(values_.size()); }
  int channels() const { return channels_; }
  const Image& mask() const { return mask_; }
  /// Foreground values of a run in row-major order, channels interleaved.
  std::span<const float> run(int index) const { return values_[static_cast<std::size_t>(index)]; }

  /// Per pixel and channel; 0 outside the mask. The mean needs one run, the unbiased variance
  /// s^2 = sum (x - mean)^2 / (K - 1) two; InputError otherwise.
  Image mean() const;
  Image variance() const;

 private:
  Image mask_;
  std::vector<std::size_t> foreground_;  // pixel indices
  int channels_ = 0;
  std::vector<std::vector<float>> values_;
};

/// A value with its interval, or the reason why there is none.
struct Estimate {
  std::optional<double> value;
  /// Empty for K < 3, and where leaving a run out leaves no noise to take the logarithm of.
  std::optional<Interval> interval;
  std::string reason;  ///< why `value` is empty; empty otherwise
};

/// Noise and bias of K runs against a reference, in units of the reference's mean luminance over
/// the mask (squared where so named); means over the mask and the channels, before any root.
///
///   noise^2 = mean s^2,   bias^2 = mean((xbar - r)^2 - s^2/K - sigma_ref^2),   mse = bias^2 +
///   noise^2
///
/// All three are unbiased, and mse is exactly the mean of (x - r)^2 over runs, less sigma_ref^2.
/// Intervals: delete-one jackknife over the runs with Student's t of K - 1 degrees of freedom, on a
/// logarithmic scale for the noise. They speak about other seeds for these very pixels; other views
/// and scenes are for the statistics over cells. The interval of the bias also holds the
/// reference's own noise; on the safe side it is taken as fully correlated between the channels and
/// between the 16 pixels of a tile, which share their random numbers (trace/reference.h).
///
/// Coverage of nominal 95% intervals, simulated with K = 8 and 16: noise and noise ratio 93-95%,
/// whether pixels err independently or all alike; bias^2 95% and more for independent pixels, but
/// down to 85% (its difference: 83%) where a run's error is one number for all pixels, about as
/// large as the bias.
struct NoiseBias {
  int runs = 0;
  std::size_t pixels = 0;
  double mean_luminance = 0.0;  ///< of the reference over the mask, in radiance
  Estimate noise_squared;
  Estimate noise;
  Estimate bias_squared;  ///< may be negative where the bias is smaller than what K runs resolve
  Estimate bias;          ///< its root; empty with a reason where bias_squared is negative
  Estimate mse;           ///< without interval
  /// The same two with run i left out (K values, empty for K < 3), which pair two methods.
  std::vector<double> noise_squared_without;
  std::vector<double> bias_squared_without;
  /// Standard deviation of bias_squared that the reference's own noise causes; 0 without a
  /// variance.
  double bias_squared_reference_error = 0.0;
};

/// Needs K >= 2 runs for the values and K >= 3 for the intervals; use K >= 8, below which the
/// intervals are wide and the jackknife rough. `reference_variance` (of the reference's pixel
/// means, as many channels as the reference) may be null: then sigma_ref = 0 and the noise of the
/// reference counts as bias.
///
/// InputError for K < 2, sizes or channels that differ from the runs', and values in the mask that
/// are not finite in the reference or the variance, or a negative variance. Where runs hold values
/// that are not finite, or the reference is black, every estimate is empty and says so.
NoiseBias noise_and_bias(const RunStatistics& runs, const Image& reference,
                         const Image* reference_variance = nullptr, double confidence = 0.95);

/// noise(a) / noise(b) with its interval, for runs paired by seed: the jackknife leaves the same
/// run out of both, so that what both share cancels. InputError where the number of runs differs;
/// empty with a reason where either was not measured or b is without noise.
Estimate noise_ratio(const NoiseBias& a, const NoiseBias& b, double confidence = 0.95);

/// bias^2(a) - bias^2(b) likewise, against one and the same reference. The reference's noise is
/// added on the safe side, as if it pushed the two apart.
Estimate bias_squared_difference(const NoiseBias& a, const NoiseBias& b, double confidence = 0.95);

}  // namespace occlab
