#include "harness/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

void require_sample(std::span<const double> sample, std::size_t smallest, const char* what) {
  if (sample.size() < smallest) {
    throw InputError(
        fmt::format("statistics: the {} of {} values was asked for; it needs at least "
                    "{}",
                    what, sample.size(), smallest));
  }
  for (std::size_t i = 0; i < sample.size(); ++i) {
    if (!std::isfinite(sample[i])) {
      throw InputError(
          fmt::format("statistics: value {} of the sample is {}; accepted: finite "
                      "values",
                      i, sample[i]));
    }
  }
}

void require_probability(double probability, const char* what) {
  if (!(probability >= 0.0 && probability <= 1.0)) {
    throw InputError(fmt::format("statistics: {} is {}; accepted: 0 to 1", what, probability));
  }
}

void require_confidence(double confidence) {
  if (!(confidence > 0.0 && confidence < 1.0)) {
    throw InputError(
        fmt::format("statistics: confidence is {}; accepted: above 0, below 1", confidence));
  }
}

void require_pairs(std::span<const double> a, std::span<const double> b) {
  if (a.size() != b.size()) {
    throw InputError(fmt::format("statistics: pairs of {} and {} values; accepted: equal numbers",
                                 a.size(), b.size()));
  }
}

std::vector<double> paired_ratios(std::span<const double> a, std::span<const double> b) {
  require_pairs(a, b);
  require_sample(a, 1, "ratio");
  require_sample(b, 1, "ratio");
  std::vector<double> ratios(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (b[i] == 0.0) {
      throw InputError(fmt::format("statistics: the denominator of pair {} is 0", i));
    }
    ratios[i] = a[i] / b[i];
  }
  return ratios;
}

// Reorders its argument.
double quantile_in_place(std::span<double> sample, double probability) {
  const double position = static_cast<double>(sample.size() - 1) * probability;
  const auto below = static_cast<std::ptrdiff_t>(std::floor(position));
  const auto at = sample.begin() + below;
  std::nth_element(sample.begin(), at, sample.end());
  const double fraction = position - static_cast<double>(below);
  if (fraction == 0.0) return *at;
  const double above = *std::min_element(at + 1, sample.end());
  return *at + fraction * (above - *at);
}

// The root of an increasing function between two bounds, to the last bit.
template <typename Function>
double bisect(double low, double high, Function&& function) {
  for (;;) {
    const double middle = 0.5 * (low + high);
    if (!(low < middle && middle < high)) return middle;
    (function(middle) < 0.0 ? low : high) = middle;
  }
}

// Continued fraction of the incomplete beta function by Lentz's method (Press et al., Numerical
// Recipes, 3rd ed., section 6.4); converges fast for x < (a + 1)/(a + b + 2).
double beta_fraction(double a, double b, double x) {
  constexpr double tiny = 1e-300;
  const auto away_from_zero = [](double v) { return std::abs(v) < tiny ? tiny : v; };
  double c = 1.0;
  double d = 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0));
  double result = d;
  for (int i = 1; i < 10000; ++i) {
    const double even = i * (b - i) * x / ((a + 2 * i - 1) * (a + 2 * i));
    d = 1.0 / away_from_zero(1.0 + even * d);
    c = away_from_zero(1.0 + even / c);
    result *= d * c;
    const double odd = -(a + i) * (a + b + i) * x / ((a + 2 * i) * (a + 2 * i + 1));
    d = 1.0 / away_from_zero(1.0 + odd * d);
    c = away_from_zero(1.0 + odd / c);
    result *= d * c;
    if (std::abs(d * c - 1.0) < 1e-15) break;
  }
  return result;
}

// Regularised incomplete beta function I_x(a, b); `complement` is 1 - x, given apart so that x near
// 1 keeps its digits.
double incomplete_beta(double a, double b, double x, double complement) {
  if (x <= 0.0) return 0.0;
  if (complement <= 0.0) return 1.0;
  const double front = std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) +
                                a * std::log(x) + b * std::log(complement));
  if (x < (a + 1.0) / (a + b + 2.0)) return front * beta_fraction(a, b, x) / a;
  return 1.0 - front * beta_fraction(b, a, complement) / b;
}

double student_upper_tail(double t, double degrees) {
  const double sum = degrees + t * t;
  return 0.5 * incomplete_beta(0.5 * degrees, 0.5, degrees / sum, t * t / sum);
}

// P(Binomial(n, 1/2) <= k)
double fair_binomial_cdf(std::size_t n, std::size_t k) {
  const auto size = static_cast<double>(n);
  double sum = 0.0;
  for (std::size_t i = 0; i <= k; ++i) {
    const auto chosen = static_cast<double>(i);
    sum += std::exp(std::lgamma(size + 1.0) - std::lgamma(chosen + 1.0) -
                    std::lgamma(size - chosen + 1.0) - size * std::log(2.0));
  }
  return sum;
}

}  // namespace

double quantile(std::span<const double> sample, double probability) {
  require_sample(sample, 1, "quantile");
  require_probability(probability, "the probability of a quantile");
  std::vector<double> copy(sample.begin(), sample.end());
  return quantile_in_place(copy, probability);
}

double median(std::span<const double> sample) { return quantile(sample, 0.5); }

Quartiles quartiles(std::span<const double> sample) {
  return {quantile(sample, 0.25), quantile(sample, 0.5), quantile(sample, 0.75)};
}

double mean(std::span<const double> sample) {
  require_sample(sample, 1, "mean");
  return std::accumulate(sample.begin(), sample.end(), 0.0) / static_cast<double>(sample.size());
}

double variance(std::span<const double> sample) {
  require_sample(sample, 2, "variance");
  const double centre = mean(sample);
  double sum = 0.0;
  for (const double value : sample) sum += (value - centre) * (value - centre);
  return sum / static_cast<double>(sample.size() - 1);
}

double normal_cdf(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

double normal_quantile(double probability) {
  require_probability(probability, "the probability of a normal quantile");
  if (probability == 0.0) return -infinity;
  if (probability == 1.0) return infinity;
  // The lower half keeps its digits; 1 - p is exact for p in [1/2, 1].
  if (probability > 0.5) return -normal_quantile(1.0 - probability);
  return bisect(-40.0, 0.0, [&](double z) { return normal_cdf(z) - probability; });
}

double student_cdf(double t, double degrees) {
  if (!(degrees > 0.0)) {
    throw InputError(fmt::format("statistics: {} degrees of freedom; accepted: above 0", degrees));
  }
  return t > 0.0 ? 1.0 - student_upper_tail(t, degrees) : student_upper_tail(t, degrees);
}

double student_quantile(double probability, double degrees) {
  require_probability(probability, "the probability of a Student quantile");
  if (probability == 0.0) return -infinity;
  if (probability == 1.0) return infinity;
  if (probability > 0.5) return -student_quantile(1.0 - probability, degrees);
  double low = -1.0;
  while (student_cdf(low, degrees) > probability) low *= 2.0;
  return bisect(low, 0.0, [&](double t) { return student_cdf(t, degrees) - probability; });
}

double student_half_width(std::span<const double> sample, double confidence) {
  require_confidence(confidence);
  const double n = double(sample.size());
  return student_quantile(0.5 + 0.5 * confidence, n - 1.0) * std::sqrt(variance(sample) / n);
}

double median_ratio(std::span<const double> a, std::span<const double> b) {
  return median(paired_ratios(a, b));
}

Interval bootstrap_median_ratio(std::span<const double> a, std::span<const double> b,
                                const Resampling& resampling) {
  require_confidence(resampling.confidence);
  if (resampling.resamples < 1) {
    throw InputError(
        fmt::format("statistics: {} resamples; accepted: 1 or more", resampling.resamples));
  }
  const std::vector<double> ratios = paired_ratios(a, b);
  PortableRandom random(resampling.seed);
  std::vector<double> medians(static_cast<std::size_t>(resampling.resamples));
  std::vector<double> resample(ratios.size());
  for (double& result : medians) {
    for (double& value : resample) value = ratios[random.index(ratios.size())];
    result = quantile_in_place(resample, 0.5);
  }
  const double tail = 0.5 * (1.0 - resampling.confidence);
  return {quantile_in_place(medians, tail), quantile_in_place(medians, 1.0 - tail),
          resampling.confidence};
}

Interval median_ratio_interval(std::span<const double> a, std::span<const double> b,
                               double confidence) {
  require_confidence(confidence);
  std::vector<double> ratios = paired_ratios(a, b);
  std::sort(ratios.begin(), ratios.end());
  const std::size_t n = ratios.size();
  const auto coverage = [&](std::size_t left_out) {
    return 1.0 - 2.0 * fair_binomial_cdf(n, left_out);
  };
  std::size_t left_out = 0;  // at either end
  while (2 * (left_out + 1) < n && coverage(left_out + 1) >= confidence) ++left_out;
  return {ratios[left_out], ratios[n - 1 - left_out], n == 1 ? 0.0 : coverage(left_out)};
}

Interval mean_difference_interval(std::span<const double> a, std::span<const double> b,
                                  double confidence) {
  require_confidence(confidence);
  require_pairs(a, b);
  std::vector<double> differences(a.size());
  std::transform(a.begin(), a.end(), b.begin(), differences.begin(), std::minus<>());
  const double centre = mean(differences);
  const auto n = static_cast<double>(differences.size());
  const double standard_error = std::sqrt(variance(differences) / n);
  const double half = student_quantile(0.5 + 0.5 * confidence, n - 1.0) * standard_error;
  return {centre - half, centre + half, confidence};
}

double sidak_level(double family_level, int tests) {
  require_probability(family_level, "the false-alarm rate of a family of tests");
  if (tests < 1) throw InputError(fmt::format("statistics: {} tests; accepted: 1 or more", tests));
  return -std::expm1(std::log1p(-family_level) / tests);
}

ZTest z_test(double estimate, double expected, double standard_error, double family_level,
             int tests) {
  ZTest result;
  const double difference = estimate - expected;
  // Without an error to measure by, equal is equal and anything else is infinitely far.
  result.z = difference == 0.0 ? 0.0 : difference / standard_error;
  result.p_value = std::erfc(std::abs(result.z) / std::sqrt(2.0));
  result.critical_z = -normal_quantile(0.5 * sidak_level(family_level, tests));
  result.passes = standard_error >= 0.0 && std::abs(result.z) <= result.critical_z;
  return result;
}

std::vector<HolmTest> holm(std::span<const double> p_values, double family_level) {
  require_confidence(1.0 - family_level);
  for (const double p : p_values) require_probability(p, "a p-value");
  std::vector<std::size_t> order(p_values.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return p_values[i]; });
  std::vector<HolmTest> tests(p_values.size());
  bool rejecting = true;
  double adjusted = 0.0;
  double level = family_level;
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    const auto left = static_cast<double>(order.size() - rank);
    const double p = p_values[order[rank]];
    // From the first test that is not rejected on, all stay where it was.
    if (rejecting) level = family_level / left;
    adjusted = std::max(adjusted, std::min(1.0, p * left));
    rejecting = rejecting && p <= level;
    tests[order[rank]] = {adjusted, rejecting, level};
  }
  return tests;
}

double StudentEstimate::p_value(double hypothesis) const {
  return 2.0 * student_cdf(-std::abs(value - hypothesis) / standard_error, degrees);
}

Interval StudentEstimate::interval(double confidence) const {
  require_confidence(confidence);
  const double half = -student_quantile(0.5 * (1.0 - confidence), degrees) * standard_error;
  return {value - half, value + half, confidence};
}

StudentEstimate student_estimate(double value, double half_width, long n, double confidence) {
  require_confidence(confidence);
  if (!(half_width > 0.0) || n < 2) {
    throw InputError(
        fmt::format("statistics: a Student interval of half width {} from {} values; "
                    "accepted: above 0, 2 or more",
                    half_width, n));
  }
  const auto degrees = static_cast<double>(n - 1);
  const double quantile = -student_quantile(0.5 * (1.0 - confidence), degrees);
  return {value, half_width / quantile, degrees};
}

double jackknife_standard_error(std::span<const double> without_one) {
  const auto n = static_cast<double>(without_one.size());
  return (n - 1.0) * std::sqrt(variance(without_one) / n);
}

}  // namespace occlab
