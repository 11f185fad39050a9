#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "harness/metrics/fast_math.h"

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

constexpr Xyz rgb_to_xyz(const Rgb& rgb) {
  constexpr auto m = xyz_from_rgb;
  return {m[0][0] * rgb[0] + m[0][1] * rgb[1] + m[0][2] * rgb[2],
          m[1][0] * rgb[0] + m[1][1] * rgb[1] + m[1][2] * rgb[2],
          m[2][0] * rgb[0] + m[2][1] * rgb[1] + m[2][2] * rgb[2]};
}

/// Relative luminance Y of linear RGB.
constexpr double luminance(const Rgb& rgb) { return rgb_to_xyz(rgb)[1]; }

/// sRGB encoding (IEC 61966-2-1) of a linear value; not clamped.
template <typename T>
inline T srgb_encode(T linear) {
  constexpr T line_up_to = T(0.0031308);
  // x^(1/2.4) = x^(5/12) = c sqrt(sqrt(c)) with c the cube root: several times faster than pow.
  const T root = fast_cbrt(std::max(linear, line_up_to));
  const T curve = T(1.055) * root * std::sqrt(std::sqrt(root)) - T(0.055);
  return linear <= line_up_to ? T(12.92) * linear : curve;
}

/// The function of CIE 1976 L*a*b* of a tristimulus value relative to the white's.
template <typename T>
inline T lab_response(T t) {
  constexpr T delta = T(6.0 / 29.0);
  constexpr T line_up_to = delta * delta * delta;
  const T root = fast_cbrt(std::max(t, line_up_to));
  const T line = t / (T(3.0) * delta * delta) + T(4.0 / 29.0);
  return t > line_up_to ? root : line;
}

/// CIE 1976 L*a*b* relative to the white of linear RGB (1, 1, 1).
inline Lab xyz_to_lab(const Xyz& xyz) {
  const double x = lab_response(xyz[0] / white_xyz[0]);
  const double y = lab_response(xyz[1] / white_xyz[1]);
  const double z = lab_response(xyz[2] / white_xyz[2]);
  return {116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)};
}

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
