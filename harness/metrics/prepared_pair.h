#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "harness/metrics/colour.h"
#include "harness/metrics/metrics.h"

namespace occlab {

/// One value a pixel, row-major; 0 outside the foreground.
using Plane = std::vector<float>;
using Planes = std::array<Plane, 3>;

inline Rgb colour_at(const Planes& planes, std::size_t index) {
  return {planes[0][index], planes[1][index], planes[2][index]};
}

inline float* row_of(Plane& plane, int row, std::size_t width) {
  return plane.data() + static_cast<std::size_t>(row) * width;
}
inline const float* row_of(const Plane& plane, int row, std::size_t width) {
  return plane.data() + static_cast<std::size_t>(row) * width;
}
/// Colours of one image as a display would show them: scaled by the shared exposure, clamped to
/// [0, 1].
struct Displayed {
  Planes srgb;  ///< encoded R', G', B'
  Planes lab;   ///< CIE L*a*b*
};

/// The set S in which colour error is measured: foreground where the reference's ambient occlusion
/// is below 0.9 and both luminances exceed 1% of the reference's mean luminance.
struct Shadow {
  std::vector<std::uint8_t> member;
  std::size_t candidates = 0;  ///< foreground pixels with ambient occlusion below 0.9
  std::size_t members = 0;
};

/// The reference's luminance over the foreground, relative to its mean.
struct LuminanceRange {
  double median = 0.0;
  double white = 0.0;  ///< 99th percentile
  double maximum = 0.0;
};

/// What several metrics need, computed once. Radiances are divided by the reference's mean
/// luminance over the foreground, as the constants in the metrics are pure numbers.
struct PreparedPair {
  int width = 0;
  int height = 0;
  std::size_t foreground_count = 0;
  Plane foreground;  ///< 1 in the foreground
  double mean_luminance = 0.0;
  Planes reference;
  Planes test;
  std::optional<Planes> reference_variance;
  LuminanceRange reference_luminance;
  std::optional<Shadow> shadow;  ///< empty without the reference's ambient occlusion
  /// Both empty where the reference's 99th-percentile luminance is not positive.
  std::optional<Displayed> reference_displayed;
  std::optional<Displayed> test_displayed;
  std::string failure;  ///< why nothing can be measured; then only the sizes above are filled in
};

/// Throws InputError as measure() says.
PreparedPair prepare(const ComparisonInput& input);

/// Checks shapes and values of the input as measure() says; returns the foreground's indices.
std::vector<std::size_t> check_input(const ComparisonInput& input);

}  // namespace occlab
