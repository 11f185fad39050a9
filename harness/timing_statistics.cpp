#include "harness/timing_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr double confidence_of_exponents = 0.95;
constexpr double level_of_curvature = 0.01;
constexpr double tolerated_change_of_slope = 0.05;
constexpr std::size_t fewest_asymptotic_points = 3;

/// P(Binomial(n, 1/2) < k), which an interval from the k-th smallest to the k-th largest misses on
/// either side.
double missed_on_one_side(std::size_t n, std::size_t k) {
  double sum = 0.0;
  double term = std::exp2(-double(n));
  for (std::size_t i = 0; i < k; ++i) {
    sum += term;
    term *= double(n - i) / double(i + 1);
  }
  return sum;
}

struct Line {
  double slope = 0.0;
  double change_of_slope = 0.0;  ///< from the first x to the last, of the parabola
};

/// Least squares in log x and log y: of a line, and the quadratic term orthogonal to it.
Line fit_line(std::span<const double> log_x, std::span<const double> log_y) {
  const auto n = double(log_x.size());
  const double centre = mean(log_x);
  double square = 0.0;
  double cube = 0.0;
  for (const double x : log_x) {
    square += std::pow(x - centre, 2);
    cube += std::pow(x - centre, 3);
  }
  Line line;
  double quadratic_norm = 0.0;
  double quadratic = 0.0;
  for (std::size_t i = 0; i < log_x.size(); ++i) {
    const double x = log_x[i] - centre;
    line.slope += x * log_y[i] / square;
    const double q = x * x - square / n - x * cube / square;
    quadratic_norm += q * q;
    quadratic += q * log_y[i];
  }
  if (log_x.size() > 2) {
    line.change_of_slope = 2.0 * quadratic / quadratic_norm * (log_x.back() - log_x.front());
  }
  return line;
}

/// Of the repetitions that have every point, the logarithms, point by point.
std::vector<std::vector<double>> whole_repetitions(const std::vector<RepeatedPoint>& points) {
  std::vector<std::vector<double>> result;
  for (std::size_t r = 0; r < points.front().y.size(); ++r) {
    std::vector<double> log_y;
    for (const RepeatedPoint& point : points) log_y.push_back(std::log(point.y[r]));
    if (std::ranges::none_of(log_y, [](double y) { return std::isnan(y); })) {
      result.push_back(std::move(log_y));
    }
  }
  return result;
}

void check(const std::vector<RepeatedPoint>& points) {
  if (points.size() < 2) {
    throw InputError(
        fmt::format("a power law through {} points; accepted: 2 or more", points.size()));
  }
  const auto usable = [](double value) { return value > 0.0 && std::isfinite(value); };
  for (std::size_t i = 0; i < points.size(); ++i) {
    const RepeatedPoint& point = points[i];
    if (!usable(point.x) || (i > 0 && point.x == points[i - 1].x)) {
      throw InputError(fmt::format(
          "a power law: found x = {}; accepted: positive numbers, all different", point.x));
    }
    if (point.y.size() != points.front().y.size()) {
      throw InputError(
          fmt::format("a power law: found {} and {} repetitions; accepted: as many "
                      "of every point",
                      points.front().y.size(), point.y.size()));
    }
    for (const double y : point.y) {
      if (!usable(y) && !std::isnan(y)) {
        throw InputError(
            fmt::format("a power law: found y = {} at x = {}; accepted: above 0", y, point.x));
      }
    }
  }
}

bool resolved(const std::vector<double>& values) {
  if (values.size() < 2) return false;
  const double error = std::sqrt(variance(values) / double(values.size()));
  if (error == 0.0) return mean(values) != 0.0;
  const double t = std::abs(mean(values)) / error;
  return 2.0 * student_cdf(-t, double(values.size() - 1)) < level_of_curvature;
}

}  // namespace

Interval interpolated_median_interval(std::span<const double> sample, double confidence) {
  if (!(confidence > 0.0 && confidence < 1.0)) {
    throw InputError(
        fmt::format("the confidence of an interval is {}; accepted: above 0, below 1", confidence));
  }
  median(sample);  // throws for what is no sample
  std::vector<double> sorted(sample.begin(), sample.end());
  std::ranges::sort(sorted);
  const std::size_t n = sorted.size();
  const auto coverage = [&](std::size_t k) { return 1.0 - 2.0 * missed_on_one_side(n, k); };
  if (n == 1 || coverage(1) < confidence) {
    return {sorted.front(), sorted.back(), n == 1 ? 0.0 : coverage(1)};
  }
  // From the k-th smallest to the k-th largest; k + 1 would cover too little.
  std::size_t k = 1;
  while (2 * (k + 1) <= n && coverage(k + 1) >= confidence) ++k;
  const double inner = 2 * (k + 1) <= n + 1 ? coverage(k + 1) : 0.0;
  const double share = (coverage(k) - confidence) / (coverage(k) - inner);
  const auto rest = double(n - k);
  const double weight = rest * share / (double(k) + (rest - double(k)) * share);
  const auto between = [&](double outer, double inside) {
    return std::lerp(outer, inside, weight);
  };
  return {between(sorted[k - 1], sorted[k]), between(sorted[n - k], sorted[n - k - 1]), confidence};
}

std::optional<PowerLaw> fit_power_law(std::vector<RepeatedPoint> points) {
  std::ranges::sort(points, {}, &RepeatedPoint::x);
  check(points);
  std::vector<double> log_x;
  for (const RepeatedPoint& point : points) log_x.push_back(std::log(point.x));
  const std::vector<std::vector<double>> repetitions = whole_repetitions(points);
  if (repetitions.empty()) return std::nullopt;
  for (std::size_t first = 0;; ++first) {
    std::vector<double> slopes;
    std::vector<double> changes;
    for (const std::vector<double>& log_y : repetitions) {
      const Line line = fit_line(std::span(log_x).subspan(first), std::span(log_y).subspan(first));
      slopes.push_back(line.slope);
      changes.push_back(line.change_of_slope);
    }
    const bool curved = resolved(changes) && std::abs(mean(changes)) > tolerated_change_of_slope;
    const std::size_t left = points.size() - first;
    if (curved && left > fewest_asymptotic_points) continue;
    PowerLaw law{mean(slopes), std::nullopt, int(left), curved};
    if (slopes.size() > 1) {
      const double half =
          student_quantile(0.5 + 0.5 * confidence_of_exponents, double(slopes.size() - 1)) *
          std::sqrt(variance(slopes) / double(slopes.size()));
      law.interval = {law.exponent - half, law.exponent + half, confidence_of_exponents};
    }
    return law;
  }
}

}  // namespace occlab
