#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "harness/metrics/metrics.h"

namespace occlab {

/// A display-referred sRGB colour, each channel in [0, 1].
using DisplayColour = std::array<float, 3>;

inline constexpr DisplayColour figure_background = {0.5f, 0.5f, 0.5f};  ///< where there is no scene
inline constexpr DisplayColour not_finite_colour = {1.0f, 0.0f, 1.0f};  ///< in no colour map

/// Colours of frames and labels: red, green, blue and purple, as in the S3HO paper's Fig. 7 and 8,
/// then grey and three more. White text is legible on each. They repeat after the eighth.
DisplayColour frame_colour(std::size_t index);

/// One colour a name, in the order of first appearance over a report's figures, so that a method
/// keeps its colour from figure to figure.
std::map<std::string, DisplayColour> frame_colours(
    std::span<const std::vector<std::string>> names_of_figures);

/// The colour of an error. `signed_luminance`: -scale is blue, 0 white, +scale red (ColorBrewer
/// RdBu, colour-blind safe). `rms`: 0 is dark, scale bright (viridis). Beyond the scale the colour
/// of its end; not_finite_colour for NaN and infinities. `scale` is positive.
DisplayColour error_colour(ErrorMap kind, double error, double scale);

/// The error at the left end of the colour scale; its right end is `scale`.
double error_scale_start(ErrorMap kind, double scale);

/// The numbers printed under the colour bar: five, evenly spaced from end to end.
std::array<double, 5> error_scale_ticks(ErrorMap kind, double scale);

/// The colour bar itself, left to right: column x is the error at its centre.
Image colour_bar(ErrorMap kind, double scale, int width, int height);

}  // namespace occlab
