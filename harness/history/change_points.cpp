#include "harness/history/change_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace occlab::history {
namespace {

constexpr double farthest = 5.0;         // scaled median absolute deviations
constexpr double normal_scale = 1.4826;  // of the median absolute deviation

/// Values whose outliers are moved in.
std::vector<double> clipped(std::span<const double> values) {
  const double middle = median(values);
  std::vector<double> distances;
  for (const double value : values) distances.push_back(std::abs(value - middle));
  const double reach = farthest * normal_scale * median(distances);
  std::vector<double> result;
  for (const double value : values) {
    result.push_back(reach > 0.0 ? std::clamp(value, middle - reach, middle + reach) : value);
  }
  return result;
}

struct Split {
  std::size_t at = 0;    ///< size of the first part
  double square = -1.0;  ///< T^2
};

Split best_split(std::span<const double> values, std::size_t least) {
  const std::size_t n = values.size();
  const double mean_of_all = mean(values);
  Split best;
  double sum = 0.0;
  for (std::size_t k = 1; k + least <= n; ++k) {
    sum += values[k - 1] - mean_of_all;
    if (k < least) continue;
    // Both means, less that of all, follow from one sum.
    const double square = sum * sum * double(n) / (double(k) * double(n - k));
    if (square > best.square) best = {k, square};
  }
  return best;
}

/// The share of permutations with as large a T, the given order being one of them; above the level
/// as soon as it is clear that it will be.
double permutation_p(std::vector<double> values, const Split& observed,
                     const ChangePointSettings& settings, PortableRandom& random) {
  const double all = settings.permutations + 1.0;
  // Rounding must not tell an order from itself.
  const double limit = observed.square * (1.0 - 1e-12);
  int as_large = 1;
  for (int i = 0; i < settings.permutations; ++i) {
    for (std::size_t last = values.size() - 1; last > 0; --last) {
      std::swap(values[last], values[random.index(last + 1)]);
    }
    as_large += best_split(values, settings.least).square >= limit ? 1 : 0;
    if (as_large / all > settings.level) break;
  }
  return as_large / all;
}

struct Found {
  std::size_t first = 0;
  double p_value = 1.0;
};

class Segmentation {
 public:
  Segmentation(std::span<const double> values, const ChangePointSettings& settings)
      : values_(values), settings_(settings), random_(settings.seed) {}

  std::vector<Found> search() {
    split(0, values_.size());
    std::ranges::sort(found_, {}, &Found::first);
    refine();
    return std::move(found_);
  }

 private:
  std::vector<double> part(std::size_t begin, std::size_t end) const {
    return clipped(values_.subspan(begin, end - begin));
  }

  void split(std::size_t begin, std::size_t end) {
    if (end - begin < 2 * settings_.least) return;
    const std::vector<double> values = part(begin, end);
    const Split best = best_split(values, settings_.least);
    if (!(best.square > 0.0)) return;
    const double p = permutation_p(values, best, settings_, random_);
    if (p > settings_.level) return;
    found_.push_back({begin + best.at, p});
    split(begin, begin + best.at);
    split(begin + best.at, end);
  }

  void refine() {
    for (std::size_t i = 0; i < found_.size(); ++i) {
      const std::size_t begin = i == 0 ? 0 : found_[i - 1].first;
      const std::size_t end = i + 1 == found_.size() ? values_.size() : found_[i + 1].first;
      const Split best = best_split(part(begin, end), settings_.least);
      if (best.square > 0.0) found_[i].first = begin + best.at;
    }
  }

  std::span<const double> values_;
  const ChangePointSettings& settings_;
  PortableRandom random_;
  std::vector<Found> found_;
};

bool repeats_exactly(std::span<const double> values) {
  std::size_t equal = 0;
  for (std::size_t i = 1; i < values.size(); ++i) equal += values[i] == values[i - 1] ? 1 : 0;
  return values.size() >= 3 && 2 * equal >= values.size() - 1;
}

std::vector<Found> exact_steps(std::span<const double> values) {
  std::vector<Found> found;
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] != values[i - 1]) found.push_back({i, 0.0});
  }
  return found;
}

/// Welch's interval on a logarithmic scale; without a spread the ratio itself.
Interval ratio_interval(std::span<const double> before, std::span<const double> after) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> logarithms[2];
  for (const double value : before) logarithms[0].push_back(std::log(value));
  for (const double value : after) logarithms[1].push_back(std::log(value));
  for (const auto& side : logarithms) {
    if (!std::ranges::all_of(side, [](double x) { return std::isfinite(x); })) {
      return {nan, nan, 0.95};
    }
  }
  const double difference = mean(logarithms[1]) - mean(logarithms[0]);
  double squared = 0.0;
  double divisor = 0.0;
  for (const auto& side : logarithms) {
    if (side.size() < 2) continue;
    const double part = variance(side) / double(side.size());
    squared += part;
    divisor += part * part / (double(side.size()) - 1.0);
  }
  if (!(divisor > 0.0)) return {std::exp(difference), std::exp(difference), 0.95};
  const double half = student_quantile(0.975, squared * squared / divisor) * std::sqrt(squared);
  return {std::exp(difference - half), std::exp(difference + half), 0.95};
}

}  // namespace

std::vector<ChangePoint> find_change_points(std::span<const double> values,
                                            const ChangePointSettings& settings) {
  std::vector<Found> found =
      repeats_exactly(values) ? exact_steps(values) : Segmentation(values, settings).search();
  std::vector<ChangePoint> steps;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::size_t begin = i == 0 ? 0 : found[i - 1].first;
    const std::size_t end = i + 1 == found.size() ? values.size() : found[i + 1].first;
    const auto before = values.subspan(begin, found[i].first - begin);
    const auto after = values.subspan(found[i].first, end - found[i].first);
    steps.push_back({found[i].first, mean(before), mean(after), ratio_interval(before, after),
                     found[i].p_value});
  }
  return steps;
}

}  // namespace occlab::history
