#include "harness/metrics/colour.h"

#include <cmath>
#include <complex>
#include <numbers>

namespace occlab {
namespace {

constexpr double degrees = 180.0 / std::numbers::pi;
constexpr double radians = std::numbers::pi / 180.0;

double power_7(double x) {
  const double cube = x * x * x;
  return cube * cube * x;
}

// Hue angle in degrees in [0, 360), 0 for a colour without chroma (Sharma et al., eq. 7).
double hue_degrees(double a, double b) {
  if (a == 0.0 && b == 0.0) return 0.0;
  const double hue = std::atan2(b, a) * degrees;
  return hue < 0.0 ? hue + 360.0 : hue;
}

}  // namespace

Chromaticity xyz_to_uv(const Xyz& xyz) {
  const double sum = xyz[0] + 15.0 * xyz[1] + 3.0 * xyz[2];
  return {4.0 * xyz[0] / sum, 9.0 * xyz[1] / sum};
}

// Equation numbers are those of Sharma, Wu and Dalal 2005.
double ciede2000(const Lab& first, const Lab& second) {
  constexpr double power_25_7 = 6103515625.0;
  // (2)-(7)
  const double mean_c7 = power_7(0.5 * (chroma(first) + chroma(second)));
  const double g = 0.5 * (1.0 - std::sqrt(mean_c7 / (mean_c7 + power_25_7)));
  const double a1 = (1.0 + g) * first.a;
  const double a2 = (1.0 + g) * second.a;
  const double c1 = std::sqrt(a1 * a1 + first.b * first.b);
  const double c2 = std::sqrt(a2 * a2 + second.b * second.b);
  const double h1 = hue_degrees(a1, first.b);
  const double h2 = hue_degrees(a2, second.b);
  const bool without_chroma = c1 * c2 == 0.0;

  // (8)-(11)
  const double delta_l = second.l - first.l;
  const double delta_c = c2 - c1;
  double delta_h = without_chroma ? 0.0 : h2 - h1;
  if (delta_h > 180.0) delta_h -= 360.0;
  if (delta_h < -180.0) delta_h += 360.0;
  const double delta_hue = 2.0 * std::sqrt(c1 * c2) * std::sin(0.5 * delta_h * radians);

  // (12)-(14)
  const double mean_l = 0.5 * (first.l + second.l);
  const double mean_c = 0.5 * (c1 + c2);
  double mean_h = h1 + h2;
  if (!without_chroma) {
    if (std::abs(h1 - h2) > 180.0) mean_h += mean_h < 360.0 ? 360.0 : -360.0;
    mean_h *= 0.5;
  }

  // (15)-(21)
  // cos(k h + phase) as the real part of a product: one sine and cosine instead of four.
  const std::complex<double> hue = std::polar(1.0, mean_h * radians);
  const std::complex<double> hue_2 = hue * hue;
  const auto cosine = [](std::complex<double> multiple, std::complex<double> phase) {
    return multiple.real() * phase.real() - multiple.imag() * phase.imag();
  };
  static const std::complex<double> minus_30 = std::polar(1.0, -30.0 * radians);
  static const std::complex<double> plus_6 = std::polar(1.0, 6.0 * radians);
  static const std::complex<double> minus_63 = std::polar(1.0, -63.0 * radians);
  const double t = 1.0 - 0.17 * cosine(hue, minus_30) + 0.24 * hue_2.real() +
                   0.32 * cosine(hue_2 * hue, plus_6) - 0.20 * cosine(hue_2 * hue_2, minus_63);
  const double hue_offset = (mean_h - 275.0) / 25.0;
  const double rotation = 30.0 * std::exp(-hue_offset * hue_offset);
  const double prime_c7 = power_7(mean_c);
  const double r_c = 2.0 * std::sqrt(prime_c7 / (prime_c7 + power_25_7));
  const double l_offset = (mean_l - 50.0) * (mean_l - 50.0);
  const double s_l = 1.0 + 0.015 * l_offset / std::sqrt(20.0 + l_offset);
  const double s_c = 1.0 + 0.045 * mean_c;
  const double s_h = 1.0 + 0.015 * mean_c * t;
  const double r_t = -std::sin(2.0 * rotation * radians) * r_c;

  // (22)
  const double l = delta_l / s_l;
  const double c = delta_c / s_c;
  const double h = delta_hue / s_h;
  return std::sqrt(l * l + c * c + h * h + r_t * c * h);
}

double chroma(const Lab& lab) { return std::sqrt(lab.a * lab.a + lab.b * lab.b); }

double hue_difference_degrees(const Lab& first, const Lab& second) {
  const double cross = first.a * second.b - first.b * second.a;
  const double dot = first.a * second.a + first.b * second.b;
  return std::atan2(std::abs(cross), dot) * degrees;
}

}  // namespace occlab
