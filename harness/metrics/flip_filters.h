#pragma once

#include <array>
#include <cstddef>

namespace occlab {

// FLIP's filters (Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images") as
// separable kernels: sums of a Gaussian, or of its derivatives, along one direction times a
// Gaussian along the other. All of them reach at most `flip_reach` pixels.

inline constexpr int flip_reach = 10;

/// The paper's observer, 0.7 m from a screen 0.7 m and 3840 pixels wide: 0.7 * 3840 / 0.7 * pi /
/// 180.
inline constexpr double flip_pixels_per_degree = 67.0206432765823;

/// A kernel's centre and the taps on its positive side; those beyond its radius are 0 or were too
/// small for a float.
struct FlipTaps {
  std::array<float, flip_reach + 1> taps{};
  int radius = 0;
};

struct FlipFilters {
  /// Spatial filtering of the colour pipeline: the contrast sensitivity of each channel,
  /// symmetric, of sum 1 in two dimensions. Blue-yellow is the sum of two.
  FlipTaps achromatic, red_green;
  std::array<FlipTaps, 2> blue_yellow;  ///< applied in both directions
  std::array<float, 2> blue_yellow_weights{};
  /// Detectors of the feature pipeline: an edge or a point along one direction times the Gaussian
  /// along the other. The edge's is odd: its value at -x is minus that at x. The positive taps of
  /// each add up to 1 in two dimensions, the negative ones to -1.
  FlipTaps gaussian, edge, point;
};

const FlipFilters& flip_filters();

}  // namespace occlab
