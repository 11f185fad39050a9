#include "harness/metrics/flip_filters.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "harness/metrics/gaussian.h"

namespace occlab {
namespace {

constexpr double pi = std::numbers::pi;

// The taps as floats; those that a float sum would not notice beside the centre are left off.
FlipTaps as_floats(const std::vector<double>& taps) {
  FlipTaps result;
  const double centre = std::abs(*std::max_element(
      taps.begin(), taps.end(), [](double a, double b) { return std::abs(a) < std::abs(b); }));
  for (std::size_t k = 0; k < taps.size(); ++k) {
    if (std::abs(taps[k]) < 0.5 * std::numeric_limits<float>::epsilon() * centre) continue;
    result.taps[k] = static_cast<float>(taps[k]);
    result.radius = static_cast<int>(k);
  }
  return result;
}

// The paper's sensitivity a sqrt(pi / b) exp(-pi^2 z^2 / b) at the distance z in degrees is a
// Gaussian of this many pixels.
double sigma_of_sensitivity(double b) {
  return std::sqrt(b / (2.0 * pi * pi)) * flip_pixels_per_degree;
}

// Sum of the two-dimensional kernel over all taps.
double sum_of_sensitivity(double a, double b) {
  double line = 1.0;
  const double sigma = sigma_of_sensitivity(b);
  for (int k = 1; k <= flip_reach; ++k) line += 2.0 * std::exp(-0.5 * k * k / (sigma * sigma));
  return a * std::sqrt(pi / b) * line * line;
}

FlipTaps sensitivity(double b) {
  return as_floats(gaussian_taps(sigma_of_sensitivity(b), flip_reach));
}

FlipFilters make_filters() {
  FlipFilters filters;
  // The paper's table of a and b for the achromatic, the red-green and the blue-yellow channel.
  // Where there is one Gaussian only, a has no effect.
  filters.achromatic = sensitivity(0.0047);
  filters.red_green = sensitivity(0.0053);
  constexpr std::array<double, 2> a = {34.1, 13.5};
  constexpr std::array<double, 2> b = {0.04, 0.025};
  const std::array<double, 2> sums = {sum_of_sensitivity(a[0], b[0]),
                                      sum_of_sensitivity(a[1], b[1])};
  for (std::size_t i = 0; i < 2; ++i) {
    filters.blue_yellow[i] = sensitivity(b[i]);
    filters.blue_yellow_weights[i] = static_cast<float>(sums[i] / (sums[0] + sums[1]));
  }

  // The detectors' peak-to-trough distance is w = 0.082 degrees, two sigma; cut at 3 sigma.
  const double sigma = 0.5 * 0.082 * flip_pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3.0 * sigma));
  const std::vector<double> gaussian = gaussian_taps(sigma, radius);
  std::vector<double> edge, point;
  double edge_side = 0.0, point_centre = 0.0, point_sides = 0.0;
  for (int k = 0; k <= radius; ++k) {
    const double g = gaussian[static_cast<std::size_t>(k)];
    edge.push_back(k * g);
    edge_side += edge.back();
    point.push_back((k * k / (sigma * sigma) - 1.0) * g);
    (point.back() < 0.0 ? point_centre : point_sides) += (k == 0 ? 1.0 : 2.0) * point.back();
  }
  for (double& tap : edge) tap /= edge_side;
  for (double& tap : point) tap /= tap < 0.0 ? -point_centre : point_sides;
  filters.gaussian = as_floats(gaussian);
  filters.edge = as_floats(edge);
  filters.point = as_floats(point);
  return filters;
}

}  // namespace

const FlipFilters& flip_filters() {
  static const FlipFilters filters = make_filters();
  return filters;
}

}  // namespace occlab
