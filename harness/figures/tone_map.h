#pragma once

#include "renderers/scene/image.h"

namespace occlab {

/// The exposure that all panels of a figure share: 1 over the 99th percentile (type 7) of the
/// reference's Rec.709 luminance where the one-channel mask exceeds 0.5, as in the metrics.
/// `reference` is linear Rec.709 RGB radiance. Throws InputError for a mask of another size, an
/// empty mask, values in the mask that are not finite, and a percentile that is not positive.
double shared_exposure(const Image& reference, const Image& mask);

/// Linear Rec.709 RGB radiance x `exposure`, clamped to [0, 1], sRGB-encoded. Where the mask is 0.5
/// or less the pixel is figure_background, and where a channel is not finite it is
/// not_finite_colour, so that a broken pixel shows instead of passing for black or white. Throws
/// InputError for a mask of another size, other numbers of channels, and an exposure that is not
/// positive.
Image tone_map(const Image& radiance, double exposure, const Image& mask);

}  // namespace occlab
