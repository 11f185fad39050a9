#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderers/scene/image.h"

namespace occlab {

/// Renderings of one picture by one renderer with independent seeds: at least 4, same size and
/// channels. Their spread is the noise of their mean.
using Seeds = std::span<const Image>;

/// A 64x64 block, cut off at the right and lower edge.
struct BlockDifference {
  int x = 0;
  int y = 0;
  int channel = 0;
  std::size_t pixels = 0;   ///< that count
  double difference = 0.0;  ///< mean of a over mean of b, minus 1
  double error = 0.0;       ///< half-width of its 95% interval: Student's, from the seeds
  /// The farthest from equality that the interval allows.
  double limit() const;
};

/// How two renderers' pictures differ, and how much of that their noise explains.
struct RendererComparison {
  std::vector<BlockDifference> blocks;  ///< every channel; those with pixels enough to judge
  std::size_t blocks_left_out = 0;      ///< fewer than min_block_pixels; counted per block
  BlockDifference whole;                ///< the picture as one block, all channels' worst

  std::size_t pixels = 0;
  /// Share of the values (pixels times channels) whose |z| > 3; z below.
  double share_beyond_3_sigma = 0.0;
  /// The number of independent pixels that the share is worth: 4x4 tiles of `a` share their random
  /// numbers, so that their errors are correlated in proportion to a's part of the variance.
  double independent_pixels = 0.0;

  double rms_error_a = 0.0;  ///< RMS standard error of a's mean, over the mean of b
  double rms_error_b = 0.0;

  Image mean_a;
  Image mean_b;
  Image relative_difference;  ///< a / b - 1; 0 where b is 0 and outside the mask
  /// (a - b) over its standard error, as the standard normal value with the same tail as Student's
  /// t with Welch's degrees of freedom; |z| <= 38. 0 outside the mask.
  Image z;
};

inline constexpr int block_size = 64;
inline constexpr std::size_t min_block_pixels = 64;

/// How many samples a pixel of one seed's image is the mean of where each sample is 0 or 1, as that
/// of ambient occlusion is; 0 where they are not. Where a seed expects less than one of the rarer
/// kind, the seeds' spread does not tell the variance (all of them may have seen none): there it is
/// at least the binomial one, with the share of all samples of both renderers.
struct ZeroOneSamples {
  long a = 0;
  long b = 0;
};

/// Compares where `mask` (1 channel) is 1. `a` is RTDO's. Throws InputError where the sizes differ,
/// there are too few seeds, a value under the mask is not finite, or nothing is under the mask.
RendererComparison compare_renderers(Seeds a, Seeds b, const Image& mask,
                                     ZeroOneSamples samples = {});

/// The view-space surface of a G-buffer: 1 where the 3x3 pixels around show one smooth piece of
/// surface, so that where exactly in the pixel a renderer looks does not matter.
Image away_from_silhouettes(const Image& position_view, const Image& geometric_normal_view,
                            const Image& surface_mask);

}  // namespace occlab
