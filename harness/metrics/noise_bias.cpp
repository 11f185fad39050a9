#include "harness/metrics/noise_bias.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "harness/metrics/image_checks.h"
#include "harness/metrics/parallel.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

// All that noise and bias need to know of two runs i < j, over the foreground's values:
// noise^2 is the mean of distance/2 over the pairs, bias^2 the mean of product less sigma_ref^2.
// (Both are U-statistics, which is why they are unbiased and what makes leaving a run out cheap.)
struct PairMoments {
  int first = 0;
  int second = 0;
  double distance = 0.0;  // mean (x_i - x_j)^2
  double product = 0.0;   // mean (x_i - r)(x_j - r)
};

std::vector<float> gather(const Image& image, std::span<const std::size_t> foreground) {
  const auto channels = static_cast<std::size_t>(image.channels());
  std::vector<float> values;
  values.reserve(foreground.size() * channels);
  for (const std::size_t index : foreground) {
    const auto pixel = image.values().subspan(index * channels, channels);
    values.insert(values.end(), pixel.begin(), pixel.end());
  }
  return values;
}

Image scatter(const Image& mask, std::span<const std::size_t> foreground, int channels,
              std::span<const double> values) {
  Image image(mask.width(), mask.height(), channels);
  const auto count = static_cast<std::size_t>(channels);
  for (std::size_t i = 0; i < foreground.size(); ++i) {
    for (std::size_t c = 0; c < count; ++c) {
      image.values()[foreground[i] * count + c] = static_cast<float>(values[i * count + c]);
    }
  }
  return image;
}

// Mean and sum of squared deviations of the runs at one value, in two passes.
std::pair<double, double> mean_and_squares(const RunStatistics& runs, std::size_t index) {
  double sum = 0.0;
  for (int k = 0; k < runs.runs(); ++k) sum += runs.run(k)[index];
  const double centre = sum / runs.runs();
  double squares = 0.0;
  for (int k = 0; k < runs.runs(); ++k) {
    const double deviation = runs.run(k)[index] - centre;
    squares += deviation * deviation;
  }
  return {centre, squares};
}

std::vector<PairMoments> pair_moments(const RunStatistics& runs, std::span<const float> reference,
                                      double scale) {
  std::vector<PairMoments> pairs;
  for (int i = 0; i < runs.runs(); ++i) {
    for (int j = i + 1; j < runs.runs(); ++j) pairs.push_back({i, j});
  }
  const double factor = scale * scale / static_cast<double>(reference.size());
  for_each_row(
      static_cast<int>(pairs.size()),
      [&](int index) {
        PairMoments& pair = pairs[static_cast<std::size_t>(index)];
        const std::span<const float> a = runs.run(pair.first);
        const std::span<const float> b = runs.run(pair.second);
        double distance = 0.0;
        double product = 0.0;
        for (std::size_t v = 0; v < reference.size(); ++v) {
          const double ea = double(a[v]) - double(reference[v]);
          const double eb = double(b[v]) - double(reference[v]);
          distance += (ea - eb) * (ea - eb);
          product += ea * eb;
        }
        pair.distance = factor * distance;
        pair.product = factor * product;
      },
      reference.size());
  return pairs;
}

struct Squares {
  double noise = 0.0;
  double bias = 0.0;
};

// The estimates from all runs but `left_out` (none: -1).
Squares squares_without(const std::vector<PairMoments>& pairs, int left_out,
                        double reference_variance) {
  Squares sum;
  int count = 0;
  for (const PairMoments& pair : pairs) {
    if (pair.first == left_out || pair.second == left_out) continue;
    sum.noise += 0.5 * pair.distance;
    sum.bias += pair.product;
    ++count;
  }
  return {sum.noise / count, sum.bias / count - reference_variance};
}

double student_factor(double confidence, int runs) {
  return student_quantile(0.5 + 0.5 * confidence, runs - 1.0);
}

bool positive(double value) { return value > 0.0; }

// Interval of a positive statistic whose logarithm is jackknifed.
std::optional<Interval> logarithmic_interval(double value, std::span<const double> without,
                                             double confidence) {
  if (without.empty()) return std::nullopt;
  const bool silent = value == 0.0;
  if (silent) return Interval{0.0, 0.0, confidence};
  if (!std::all_of(without.begin(), without.end(), positive)) return std::nullopt;
  std::vector<double> logs(without.size());
  std::transform(without.begin(), without.end(), logs.begin(),
                 [](double v) { return std::log(v); });
  const double half =
      student_factor(confidence, static_cast<int>(without.size())) * jackknife_standard_error(logs);
  return Interval{value * std::exp(-half), value * std::exp(half), confidence};
}

// Pixels of a traced reference that share their rays' random numbers: a tile of 4x4.
constexpr double sharing_pixels = 16.0;

// The part of the variance of bias^2 that comes from the reference r = t + delta with independent
// Gaussian delta: Var(-2 b delta + delta^2) = 4 b^2 sigma^2 + 2 sigma^4 a value, where b^2 is known
// as (xbar - r)^2 - s^2/K - sigma^2. Channels share their rays, so their deltas count as one
// (Cauchy-Schwarz); so do those of the pixels of a tile.
double reference_error(const RunStatistics& runs, std::span<const float> reference,
                       std::span<const float> variances, double scale) {
  const auto count = static_cast<double>(runs.runs());
  double sum = 0.0;
  for (std::size_t v = 0; v < reference.size(); ++v) {
    const auto [centre, squares] = mean_and_squares(runs, v);
    const double square = (centre - reference[v]) * (centre - reference[v]);
    const double sigma2 = variances[v];
    sum += 4.0 * sigma2 * (square - squares / (count * (count - 1.0))) - 2.0 * sigma2 * sigma2;
  }
  const auto channels = static_cast<double>(runs.channels());
  const double pixels = static_cast<double>(reference.size()) / channels;
  return scale * scale * std::sqrt(sharing_pixels * std::max(0.0, sum / channels)) / pixels;
}

Interval bias_interval(const Interval& squared) {
  return {std::sqrt(std::max(0.0, squared.low)), std::sqrt(std::max(0.0, squared.high)),
          squared.confidence};
}

void fail(NoiseBias& result, const std::string& reason) {
  for (Estimate* estimate :
       {&result.noise_squared, &result.noise, &result.bias_squared, &result.bias, &result.mse}) {
    estimate->reason = reason;
  }
}

}  // namespace

RunStatistics::RunStatistics(const Image& mask)
    : mask_(mask), foreground_(foreground_pixels(mask)) {}

void RunStatistics::add(const Image& run) {
  if (values_.empty()) {
    if (run.channels() != 1 && run.channels() != 3) {
      throw InputError(fmt::format("run image: {} channels; accepted: 1 or 3", run.channels()));
    }
    channels_ = run.channels();
  }
  require_shape(run, "run", mask_, channels_);
  values_.push_back(gather(run, foreground_));
}

Image RunStatistics::mean() const {
  if (runs() < 1) throw InputError("mean of runs: 0 runs; accepted: 1 or more");
  std::vector<double> result(values_.front().size());
  for (std::size_t v = 0; v < result.size(); ++v) result[v] = mean_and_squares(*this, v).first;
  return scatter(mask_, foreground_, channels_, result);
}

Image RunStatistics::variance() const {
  if (runs() < 2) {
    throw InputError(fmt::format("variance of runs: {} runs; accepted: 2 or more", runs()));
  }
  std::vector<double> result(values_.front().size());
  for (std::size_t v = 0; v < result.size(); ++v) {
    result[v] = mean_and_squares(*this, v).second / (runs() - 1.0);
  }
  return scatter(mask_, foreground_, channels_, result);
}

NoiseBias noise_and_bias(const RunStatistics& runs, const Image& reference,
                         const Image* reference_variance, double confidence) {
  if (runs.runs() < 2) {
    throw InputError(fmt::format(
        "noise and bias: {} runs; accepted: 2 or more (8 or more are advised)", runs.runs()));
  }
  require_shape(reference, "reference", runs.mask(), runs.channels());
  const std::vector<std::size_t> foreground = foreground_pixels(runs.mask());
  require_finite(reference, "reference", foreground);
  std::vector<float> variances;
  if (reference_variance != nullptr) {
    require_shape(*reference_variance, "reference variance", runs.mask(), runs.channels());
    require_finite_non_negative(*reference_variance, "reference variance", foreground);
    variances = gather(*reference_variance, foreground);
  }

  NoiseBias result;
  result.runs = runs.runs();
  result.pixels = foreground.size();
  result.mean_luminance = mean_luminance(reference, foreground);
  if (!(result.mean_luminance > 0.0)) {
    fail(result, fmt::format("the reference's mean luminance over the foreground is {}, and errors "
                             "are relative to it",
                             result.mean_luminance));
    return result;
  }
  std::ptrdiff_t bad = 0;
  for (int k = 0; k < runs.runs(); ++k) {
    bad += std::count_if(runs.run(k).begin(), runs.run(k).end(),
                         [](float value) { return !std::isfinite(value); });
  }
  if (bad != 0) {
    fail(result, fmt::format("{} non-finite values in {} runs", bad, runs.runs()));
    return result;
  }

  const double scale = 1.0 / result.mean_luminance;
  const std::vector<float> expected = gather(reference, foreground);
  double mean_variance = 0.0;
  for (const float variance : variances) mean_variance += variance;
  mean_variance *= scale * scale / static_cast<double>(expected.size());

  const std::vector<PairMoments> pairs = pair_moments(runs, expected, scale);
  const Squares all = squares_without(pairs, -1, mean_variance);
  if (runs.runs() >= 3) {
    for (int k = 0; k < runs.runs(); ++k) {
      const Squares without = squares_without(pairs, k, mean_variance);
      result.noise_squared_without.push_back(without.noise);
      result.bias_squared_without.push_back(without.bias);
    }
  }

  result.noise_squared.value = all.noise;
  result.noise_squared.interval =
      logarithmic_interval(all.noise, result.noise_squared_without, confidence);
  result.noise.value = std::sqrt(all.noise);
  if (const auto& squared = result.noise_squared.interval) {
    result.noise.interval =
        Interval{std::sqrt(squared->low), std::sqrt(squared->high), squared->confidence};
  }
  if (!variances.empty()) {
    result.bias_squared_reference_error = reference_error(runs, expected, variances, scale);
  }
  result.bias_squared.value = all.bias;
  if (!result.bias_squared_without.empty()) {
    const double half = student_factor(confidence, result.runs) *
                        std::hypot(jackknife_standard_error(result.bias_squared_without),
                                   result.bias_squared_reference_error);
    result.bias_squared.interval = Interval{all.bias - half, all.bias + half, confidence};
    result.bias.interval = bias_interval(*result.bias_squared.interval);
  }
  if (all.bias >= 0.0) {
    result.bias.value = std::sqrt(all.bias);
  } else {
    result.bias.reason = fmt::format(
        "{} runs do not resolve it: the estimate of its square is {:.3g}", result.runs, all.bias);
  }
  result.mse.value = all.bias + all.noise;
  return result;
}

namespace {

// Two methods can be paired where both were measured with the same number of runs.
std::string why_not_paired(const NoiseBias& a, const NoiseBias& b) {
  if (a.runs != b.runs) {
    throw InputError(
        fmt::format("paired runs: {} and {} runs; accepted: equal numbers, the same "
                    "seeds in the same order",
                    a.runs, b.runs));
  }
  return a.noise_squared.value ? b.noise_squared.reason : a.noise_squared.reason;
}

}  // namespace

Estimate noise_ratio(const NoiseBias& a, const NoiseBias& b, double confidence) {
  Estimate result;
  result.reason = why_not_paired(a, b);
  if (!result.reason.empty()) return result;
  if (*b.noise_squared.value == 0.0) {
    result.reason = "the denominator is without noise";
    return result;
  }
  const double squared = *a.noise_squared.value / *b.noise_squared.value;
  result.value = std::sqrt(squared);
  std::vector<double> without(a.noise_squared_without.size());
  for (std::size_t k = 0; k < without.size(); ++k) {
    // A silent denominator leaves no ratio: 0 tells logarithmic_interval so.
    const double below = b.noise_squared_without[k];
    without[k] = below > 0.0 ? a.noise_squared_without[k] / below : 0.0;
  }
  if (const auto interval = logarithmic_interval(squared, without, confidence)) {
    result.interval = Interval{std::sqrt(interval->low), std::sqrt(interval->high), confidence};
  }
  return result;
}

Estimate bias_squared_difference(const NoiseBias& a, const NoiseBias& b, double confidence) {
  Estimate result;
  result.reason = why_not_paired(a, b);
  if (!result.reason.empty()) return result;
  result.value = *a.bias_squared.value - *b.bias_squared.value;
  if (a.bias_squared_without.empty()) return result;
  std::vector<double> without(a.bias_squared_without.size());
  std::transform(a.bias_squared_without.begin(), a.bias_squared_without.end(),
                 b.bias_squared_without.begin(), without.begin(), std::minus<>());
  const double half = student_factor(confidence, a.runs) *
                      std::hypot(jackknife_standard_error(without),
                                 a.bias_squared_reference_error + b.bias_squared_reference_error);
  result.interval = Interval{*result.value - half, *result.value + half, confidence};
  return result;
}

}  // namespace occlab
