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

/// Linear RGB to CIE XYZ (IEC 61966-2-1), row by row; the second row is the luminance of ITU-R
/// BT.709.
inline constexpr std::array<Rgb, 3> xyz_from_rgb = {
    {{0.4124, 0.3576, 0.1805}, {0.2126, 0.7152, 0.0722}, {0.0193, 0.1192, 0.9505}}};

/// XYZ of linear RGB (1, 1, 1). Relative to it, and not to a D65 of more digits, greys are exactly
/// without chroma.
inline constexpr Xyz white_xyz = {xyz_from_rgb[0][0] + xyz_from_rgb[0][1] + xyz_from_rgb[0][2], 1.0,
                                  xyz_from_rgb[2][0] + xyz_from_rgb[2][1] + xyz_from_rgb[2][2]};

/// Relative luminance Y of linear RGB.
constexpr double luminance(const Rgb& rgb) {
  return xyz_from_rgb[1][0] * rgb[0] + xyz_from_rgb[1][1] * rgb[1] + xyz_from_rgb[1][2] * rgb[2];
}

/// sRGB encoding (IEC 61966-2-1) of a linear value; not clamped. The one for float is 3 times
/// faster.
double srgb_encode(double linear);
float srgb_encode(float linear);

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
