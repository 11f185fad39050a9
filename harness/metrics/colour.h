#pragma once

#include <array>

namespace occlab {

// Colours in double precision. Linear RGB has the primaries and the white (D65) of Rec.709 and
// sRGB. XYZ is scaled so that linear RGB (1, 1, 1) has Y = 1.

using Rgb = std::array<double, 3>;
using Xyz = std::array<double, 3>;

struct Lab {
  double l = 0.0;
  double a = 0.0;
  double b = 0.0;
};

/// CIE 1976 u'v' chromaticity.
struct Chromaticity {
  double u = 0.0;
  double v = 0.0;
};

/// Relative luminance Y of linear RGB (ITU-R BT.709): also the second row of rgb_to_xyz.
constexpr double luminance(const Rgb& rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

/// sRGB encoding (IEC 61966-2-1) of a linear value; not clamped. The one for float is 3 times
/// faster.
double srgb_encode(double linear);
float srgb_encode(float linear);

/// Linear RGB to CIE XYZ (IEC 61966-2-1).
Xyz rgb_to_xyz(const Rgb& rgb);

/// CIE 1976 L*a*b* relative to the white of linear RGB (1, 1, 1).
Lab xyz_to_lab(const Xyz& xyz);

/// X + 15 Y + 3 Z must not be 0.
Chromaticity xyz_to_uv(const Xyz& xyz);

/// CIEDE2000 colour difference with k_L = k_C = k_H = 1 (Sharma, Wu and Dalal 2005, "The CIEDE2000
/// color-difference formula: implementation notes").
double ciede2000(const Lab& first, const Lab& second);

/// Chroma C*.
double chroma(const Lab& lab);

/// Angle between the hues of two colours in degrees, 0 to 180; both chromas must be positive.
double hue_difference_degrees(const Lab& first, const Lab& second);

}  // namespace occlab
