#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "renderers/scene/image.h"

namespace occlab {

/// What a metric made of an image pair: a number, or the reason why there is none. Never a 0 that
/// stands for "unknown".
struct Measured {
  std::optional<double> value;  ///< finite, but for the PSNR of equal images, which is +infinity
  std::string reason;           ///< why `value` is empty; empty otherwise
  std::size_t pixels = 0;       ///< how many pixels (SSIM: windows) the mean is over
};

struct MetricValue : Measured {
  std::string name;
  std::string unit;
};

/// The images of one comparison; all have the reference's size. They are only read.
struct ComparisonInput {
  const Image& reference;  ///< linear Rec.709 RGB radiance; finite in the mask
  const Image& test;       ///< linear Rec.709 RGB radiance
  const Image& mask;       ///< one channel; the foreground F is where it exceeds 0.5
  /// Cosine-weighted ambient occlusion k_A of the reference, one channel, 1 = open. Without it the
  /// metrics in shadow could not be measured.
  const Image* reference_occlusion = nullptr;
  /// Variance of the reference's pixel means, three channels, in radiance squared, >= 0. With it
  /// `rmse` and `relmse` are those against the noise-free reference.
  const Image* reference_variance = nullptr;
};

struct PreparedPair;  // what the metrics share, see prepared_pair.h

struct MetricInfo {
  std::string name;        ///< as in measurements.csv
  std::string unit;        ///< "1" for a pure number
  std::string definition;  ///< one sentence or two
  bool lower_is_better;
  Measured (*measure)(const PreparedPair&);
};

/// Every metric of an image pair, in the order of the tables. A new metric is one more entry.
const std::vector<MetricInfo>& metrics();

/// All metrics of the pair, in the order of metrics(). Multi-threaded; the result does not depend
/// on the number of threads.
///
/// Throws InputError for images of different size, a number of channels other than stated above, an
/// empty mask, and values in the mask that are not finite in the reference, its occlusion, its
/// variance or the mask itself, or a negative variance. Test pixels in the mask that are not finite
/// are counted, and then every value is empty with that count as its reason; so it is where the
/// reference is black, as it has no mean luminance to divide by.
std::vector<MetricValue> measure(const ComparisonInput& input);

enum class ErrorMap {
  signed_luminance,  ///< (Y_test - Y_reference) / mean_F Y_reference
  rms,               ///< root mean square of test - reference over R, G, B, / mean_F Y_reference
};

/// Per-pixel error for figures: one channel, in units of the reference's mean luminance over the
/// mask, 0 outside of it, NaN where the test image is not finite. Throws as measure() does, and
/// InputError where the reference is black.
Image error_map(const ComparisonInput& input, ErrorMap kind);

}  // namespace occlab
