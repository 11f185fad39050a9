#include "harness/paired_bootstrap.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr std::size_t most_seeds_to_enumerate = 8;  // 6435 resamples; 9 seeds have 24310

// Resamples that are computed side by side; the counts are padded to a multiple of it.
constexpr std::size_t block_size = 64;
using Block = std::array<double, block_size>;

struct Centred {
  double mean = 0.0;
  std::vector<double> values;  // less the mean
  bool constant = false;       // equal but for the rounding of a subtraction
};

Centred centre(std::span<const double> differences) {
  Centred result;
  result.mean = mean(differences);
  for (const double value : differences) result.values.push_back(value - result.mean);
  const auto [low, high] = std::ranges::minmax(differences);
  result.constant = high - low <= 1e-9 * std::abs(result.mean);
  return result;
}

// Unbiased squared error of a mean of n values, from their mean square and mean.
double squared_error(double mean_square, double mean, std::size_t n) {
  const double variance = mean_square - mean * mean;
  // Squares that cancel to so little are the rounding errors of 0.
  return (variance > 1e-12 * mean_square ? variance : 0.0) / double(n - 1);
}

// Infinite without an error to divide by, even where the mean is 0; no branch, for the vectoriser.
double squared_t(double mean, double squared_error_of_mean) {
  return (mean * mean + std::numeric_limits<double>::min()) / squared_error_of_mean;
}

struct Tail {
  double square = 0.0;
  double probability = 0.0;
  bool operator>(const Tail& other) const { return square > other.square; }
};

// How often the seeds and the views of some resamples were drawn: [seed or view][resample].
struct Counts {
  const std::vector<std::vector<std::uint16_t>>& seeds;
  const std::vector<std::vector<std::uint16_t>>& views;
};

// t^2 of `block_size` resamples from `first` on, of centred values in rows of one view each.
void studentise(std::span<const double> values, const Counts& counts, std::size_t first,
                double* squares) {
  const std::size_t seeds = counts.seeds.size();
  const std::size_t views = counts.views.size();
  const auto add = [](Block& sum, const std::uint16_t* weights, double value) {
    for (std::size_t r = 0; r < block_size; ++r) sum[r] += weights[r] * value;
  };
  Block mean{};
  Block square_of_seeds{};
  Block square_of_views{};
  for (std::size_t s = 0; s < seeds; ++s) {
    Block over_views{};
    if (views == 1) {
      over_views.fill(values[s]);
    } else {
      for (std::size_t v = 0; v < views; ++v) {
        add(over_views, counts.views[v].data() + first, values[v * seeds + s] / double(views));
      }
    }
    const std::uint16_t* const count = counts.seeds[s].data() + first;
    for (std::size_t r = 0; r < block_size; ++r) {
      const double weighted = count[r] * over_views[r];
      mean[r] += weighted;
      square_of_seeds[r] += weighted * over_views[r];
    }
  }
  for (std::size_t v = 0; views > 1 && v < views; ++v) {
    Block over_seeds{};
    for (std::size_t s = 0; s < seeds; ++s) {
      add(over_seeds, counts.seeds[s].data() + first, values[v * seeds + s] / double(seeds));
    }
    const std::uint16_t* const count = counts.views[v].data() + first;
    for (std::size_t r = 0; r < block_size; ++r) {
      square_of_views[r] += count[r] * over_seeds[r] * over_seeds[r];
    }
  }
  Block error;
  for (std::size_t r = 0; r < block_size; ++r) {
    mean[r] /= double(seeds);
    error[r] = squared_error(square_of_seeds[r] / double(seeds), mean[r], seeds);
  }
  for (std::size_t r = 0; views > 1 && r < block_size; ++r) {
    error[r] += squared_error(square_of_views[r] / double(views), mean[r], views);
  }
  for (std::size_t r = 0; r < block_size; ++r) squares[r] = squared_t(mean[r], error[r]);
}

// The same squared error of the sample itself.
double observed_squared_error(std::span<const double> centred, std::size_t seeds,
                              std::size_t views) {
  std::vector<double> of_seeds(seeds);
  std::vector<double> of_views(views);
  for (std::size_t v = 0; v < views; ++v) {
    for (std::size_t s = 0; s < seeds; ++s) {
      of_seeds[s] += centred[v * seeds + s] / double(views);
      of_views[v] += centred[v * seeds + s] / double(seeds);
    }
  }
  const double error = variance(of_seeds) / double(seeds);
  return views == 1 ? error : error + variance(of_views) / double(views);
}

}  // namespace

PairedBootstrap::PairedBootstrap(std::size_t seeds, std::size_t views, const Resampling& resampling)
    : seeds_(seeds), views_(views), seed_counts_(seeds), view_counts_(views) {
  constexpr std::size_t most = std::numeric_limits<std::uint16_t>::max();
  if (seeds < 2 || seeds > most || views < 1 || views > most || resampling.resamples < 1) {
    throw InputError(fmt::format(
        "paired bootstrap: {} seeds, {} views, {} resamples; accepted: 2 to {}, 1 to {}, "
        "1 or more",
        seeds, views, resampling.resamples, most, most));
  }
  if (views == 1 && seeds <= most_seeds_to_enumerate) {
    enumerate();
  } else {
    draw(resampling.resamples, resampling.seed);
  }
  const std::size_t blocks = (probabilities_.size() + block_size - 1) / block_size;
  for (auto* counts : {&seed_counts_, &view_counts_}) {
    for (auto& row : *counts) row.resize(blocks * block_size, 0);
  }
}

void PairedBootstrap::add_resample(std::span<const int> seeds, std::span<const int> views,
                                   double probability) {
  for (std::size_t s = 0; s < seeds_; ++s) seed_counts_[s].push_back(std::uint16_t(seeds[s]));
  for (std::size_t v = 0; v < views_; ++v) view_counts_[v].push_back(std::uint16_t(views[v]));
  probabilities_.push_back(probability);
  const bool one_seed = std::ranges::count(seeds, 0) == std::ssize(seeds) - 1;
  const bool one_view = std::ranges::count(views, 0) == std::ssize(views) - 1;
  if (one_seed && one_view) smallest_p_ += probability;
}

void PairedBootstrap::enumerate() {
  const int size = int(seeds_);
  const std::vector<int> one_view = {1};
  std::vector<int> counts(seeds_, 0);
  // The multinomial probability size! / prod(count!) / size^size of every way to split `size`.
  const double all = std::lgamma(size + 1.0) - size * std::log(double(size));
  const auto split = [&](const auto& self, std::size_t seed, int left, double logarithm) -> void {
    if (seed + 1 == seeds_) {
      counts[seed] = left;
      add_resample(counts, one_view, std::exp(logarithm - std::lgamma(left + 1.0)));
      return;
    }
    for (int count = 0; count <= left; ++count) {
      counts[seed] = count;
      self(self, seed + 1, left - count, logarithm - std::lgamma(count + 1.0));
    }
  };
  split(split, 0, size, all);
}

void PairedBootstrap::draw(int resamples, std::uint64_t seed) {
  PortableRandom random(seed);
  const auto draw_counts = [&](std::vector<int>& counts) {
    std::ranges::fill(counts, 0);
    for (std::size_t i = 0; i < counts.size(); ++i) ++counts[random.index(counts.size())];
  };
  std::vector<int> seeds(seeds_);
  std::vector<int> views(views_);
  beyond_ = smallest_p_ = 1.0 / (resamples + 1.0);
  for (int i = 0; i < resamples; ++i) {
    draw_counts(seeds);
    draw_counts(views);
    add_resample(seeds, views, beyond_);
  }
}

std::vector<double> PairedBootstrap::studentised_squares(std::span<const double> centred) const {
  std::vector<double> squares(seed_counts_.front().size());
  for (std::size_t first = 0; first < squares.size(); first += block_size) {
    studentise(centred, {seed_counts_, view_counts_}, first, squares.data() + first);
  }
  squares.resize(probabilities_.size());
  return squares;
}

void PairedBootstrap::require_shape(std::span<const double> differences) const {
  if (differences.size() != seeds_ * views_) {
    throw InputError(
        fmt::format("paired bootstrap: {} differences; accepted: those of {} seeds in {} "
                    "views",
                    differences.size(), seeds_, views_));
  }
}

PairedDifference PairedBootstrap::test(std::span<const double> differences) const {
  require_shape(differences);
  const Centred sample = centre(differences);
  // Where the seed changes nothing: the limit of differences that spread less and less.
  if (sample.constant) return {sample.mean, 0.0, sample.mean == 0.0 ? 1.0 : smallest_p_};
  const double error = observed_squared_error(sample.values, seeds_, views_);
  // Seeds and views that cancel exactly leave no error to measure the mean by.
  if (!(error > 0.0)) return {sample.mean, 0.0, 1.0};
  const double square = squared_t(sample.mean, error);
  const std::vector<double> squares = studentised_squares(sample.values);
  double p = beyond_;
  for (std::size_t r = 0; r < squares.size(); ++r) {
    if (squares[r] >= square) p += probabilities_[r];
  }
  return {sample.mean, std::sqrt(error), std::min(p, 1.0)};
}

Interval PairedBootstrap::interval(std::span<const double> differences, double confidence) const {
  require_shape(differences);
  if (!(confidence > 0.0 && confidence < 1.0)) {
    throw InputError(
        fmt::format("paired bootstrap: confidence is {}; accepted: above 0, below 1", confidence));
  }
  const Centred sample = centre(differences);
  const double level = 1.0 - confidence;
  if (sample.constant) {
    const double half = sample.mean != 0.0 && smallest_p_ > level ? infinity : 0.0;
    return {sample.mean - half, sample.mean + half, confidence};
  }
  const double error = observed_squared_error(sample.values, seeds_, views_);
  if (!(error > 0.0)) return {-infinity, infinity, confidence};
  const std::vector<double> squares = studentised_squares(sample.values);
  // The largest t^2 that is reached or exceeded with more than the level's probability is the least
  // of the fewest largest that together have more.
  std::priority_queue<Tail, std::vector<Tail>, std::greater<>> tail;
  double probability = beyond_;
  for (std::size_t r = 0; r < squares.size() && beyond_ <= level; ++r) {
    if (probability > level && squares[r] <= tail.top().square) continue;
    tail.push({squares[r], probabilities_[r]});
    probability += probabilities_[r];
    while (probability - tail.top().probability > level) {
      probability -= tail.top().probability;
      tail.pop();
    }
  }
  const double square = tail.empty() ? infinity : tail.top().square;
  const double half = std::sqrt(square * error);
  return {sample.mean - half, sample.mean + half, confidence};
}

}  // namespace occlab
