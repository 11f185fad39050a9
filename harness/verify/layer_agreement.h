#pragma once

#include <filesystem>
#include <string>

#include "renderers/methods/frame.h"
#include "renderers/methods/method.h"
#include "renderers/methods/parameters.h"

namespace occlab {

/// The same layers made in two ways, and how far apart each value may be for the roundings of
/// both; layers of one name have one size and as many channels.
struct LayerAgreement {
  Layers measured;
  Layers expected;
  Layers bounds;
};

/// The value of all layers, pixels and channels that uses most of its bound.
struct WorstPixel {
  std::string layer;
  int x = 0;
  int y = 0;
  int channel = 0;
  double measured = 0.0;
  double expected = 0.0;
  double bound = 0.0;
  /// |measured - expected| / bound; 0 where they are equal, infinite where they differ beyond a
  /// bound of 0 or anything is not a number.
  double share = 0.0;
};

/// Looks at every pixel of the layers of `expected`. Throws InputError where one of them is missing
/// in the others or has another size or number of channels there.
WorstPixel worst_pixel(const LayerAgreement& agreement);

/// "radiance[1] at (12, 34): 0.25 for 0.26, 0.001 allowed".
std::string describe(const WorstPixel& worst);

/// A screen-space method by its shaders (measured) and on the CPU (expected), with
/// rounding_bounds(). Needs a current graphics context.
LayerAgreement gpu_and_cpu(const Frame& frame, const MethodInfo& method,
                           const ParameterSet& parameters);

/// How far the two may be apart in each layer of evaluate_on_cpu(), per pixel:
///   - a stored value c, for each of the passes (occlusion, filter) that wrote it:
///     Representation::storage_error |c|, and for what is stored as halves 2^-14, what is smaller
///     becomes 0; 2^-17 (|c| + the mean |c| of the image) for the roundings of
///     the pass's floats. The filter, whose weights are positive and add up to 1, hands on the
///     bounds of what it reads;
///   - radiance L: (rho/pi) sum_i |E(c +- b_i e_i) - E(c)| with b the bounds of the stored values,
///     the larger of the two, and 2^-17 |L|.
/// Decisions (what blocks, which texel) are the same on both, so nothing is allowed for them.
Layers rounding_bounds(const Frame& frame, const MethodInfo& method,
                       const ParameterSet& parameters);

/// Writes measured.exr, expected.exr, difference.exr and bound.exr into `folder`, which is made.
/// Throws DeviceError.
void write_agreement(const LayerAgreement& agreement, const std::filesystem::path& folder,
                     const Metadata& metadata);

}  // namespace occlab
