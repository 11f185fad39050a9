#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace occlab {

// Elementary functions without calls and branches, so that loops over pixels vectorise. The bounds
// on their errors are tested.

/// Cube root of x in [1e-30, 1e30]; relative error below 3e-7.
inline float fast_cbrt(float x) {
  // A third of the exponent, which is within 4%, and two steps of Halley's method, each of which
  // about cubes the relative error.
  float y = std::bit_cast<float>(
      static_cast<std::int32_t>(static_cast<float>(std::bit_cast<std::int32_t>(x)) / 3.0f) +
      0x2a5119f2);
  for (int step = 0; step < 2; ++step) {
    const float cube = y * y * y;
    y *= (cube + 2.0f * x) / (2.0f * cube + x);
  }
  return y;
}

/// The same in double precision; relative error below 1e-15.
inline double fast_cbrt(double x) {
  const auto y = static_cast<double>(fast_cbrt(static_cast<float>(x)));
  const double cube = y * y * y;
  return y * (cube + 2.0 * x) / (2.0 * cube + x);
}

/// log2 of a normal x > 0; absolute error below 2e-7 (1 + |log2 x|).
inline float fast_log2(float x) {
  constexpr std::int32_t sqrt_half = 0x3f3504f3;
  constexpr std::int32_t mantissa_bits = 23;
  // x = 2^exponent m with m in [sqrt(1/2), sqrt(2)).
  const std::int32_t shifted = std::bit_cast<std::int32_t>(x) - sqrt_half;
  const std::int32_t exponent = shifted >> mantissa_bits;
  const auto m = std::bit_cast<float>((shifted & 0x007fffff) + sqrt_half);
  // log2 m = 2/ln 2 artanh s, |s| < 0.172; the series' next term is below 2e-8.
  const float s = (m - 1.0f) / (m + 1.0f);
  const float q = s * s;
  const float series = ((q * (1.0f / 7.0f) + 0.2f) * q + 1.0f / 3.0f) * q + 1.0f;
  return static_cast<float>(exponent) + 2.885390082f * s * series;
}

/// 2^x for x in [-126, 127]; relative error below 3e-7.
inline float fast_exp2(float x) {
  const float whole = std::floor(x + 0.5f);
  // The exponential's series for |x - whole| ln 2 <= 0.347; its next term is below 1.3e-7.
  const float t = (x - whole) * 0.6931471806f;
  constexpr float c6 = 1.0f / 720.0f, c5 = 1.0f / 120.0f, c4 = 1.0f / 24.0f, c3 = 1.0f / 6.0f;
  const float series = (((((c6 * t + c5) * t + c4) * t + c3) * t + 0.5f) * t + 1.0f) * t + 1.0f;
  return series * std::bit_cast<float>((static_cast<std::int32_t>(whole) + 127) << 23);
}

/// x^p for x = 0 (which gives 0) or normal x > 0, and p log2 x in [-126, 127]; relative error below
/// 4e-7 (1 + |p log2 x|).
inline float fast_power(float x, float p) {
  const float power = fast_exp2(p * fast_log2(x));
  return x > 0.0f ? power : 0.0f;
}

}  // namespace occlab
