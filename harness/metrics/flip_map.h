#pragma once

#include "harness/metrics/prepared_pair.h"

namespace occlab {

/// A displayed image as FLIP filters it: the linear opponent colours Y C_x C_z (Andersson et al.
/// 2020, colour pipeline), left in [0, 1] where the paper scales them by 116, 500 and 200, as all
/// filters are linear: y = Y/Y_n, cx = X/X_n - Y/Y_n, cz = Y/Y_n - Z/Z_n.
struct FlipImage {
  int width = 0;
  int height = 0;
  Planes opponent;  ///< y, cx, cz
};

/// Linear value of the grey that stands wherever the mask is 0, in both images and at every
/// exposure: half the display's encoded range (sRGB 0.5).
inline constexpr float flip_background = 0.2140411f;

/// How radiance is displayed, channel by channel: s = exposure times radiance, below 0 as 0, then
/// s (a s + b) / (s (c s + d) + e), above 1 as 1.
struct FlipDisplay {
  float exposure;
  float a, b, c, d, e;
};

/// Exposure and clamp alone.
FlipDisplay linear_display(double exposure);

/// The tone curve that HDR-FLIP assumes (Andersson et al. 2021, "Visualizing Errors in Rendered
/// High Dynamic Range Images"): Narkowicz's fit of ACES, its built-in exposure of 0.6 taken into a
/// to e.
FlipDisplay aces_display(double exposure);

/// s for which the curve of `display` gives t, in (0, 1).
double inverse_tone(const FlipDisplay& display, double t);

/// `radiance`, one of the pair's two, as displayed.
FlipImage flip_image(const PreparedPair& pair, const Planes& radiance, const FlipDisplay& display);

/// FLIP at each pixel, 0 to 1. Both images have the same size. Outside the image its border pixels
/// go on, as in the authors' implementation. Multi-threaded; the result does not depend on the
/// threads.
Plane flip_map(const FlipImage& reference, const FlipImage& test);

}  // namespace occlab
