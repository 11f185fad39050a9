#include "harness/history/series_tests.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace occlab::history {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

EffectTest identical(std::string how) {
  EffectTest test;
  test.identical = true;
  test.effect = 0.0;
  test.how = std::move(how);
  return test;
}

EffectTest untested(std::optional<double> effect, std::string reason) {
  EffectTest test;
  test.effect = effect;
  test.reason = std::move(reason);
  return test;
}

/// A difference as a share of the baseline; of a baseline of 0 any difference is infinitely much.
double as_effect(double difference, double baseline, bool relative) {
  if (!relative || difference == 0.0) return difference;
  return difference / std::abs(baseline);
}

bool all_finite(const std::vector<double>& values) {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

/// The values of all seeds that could be measured.
std::vector<double> known_values(const SeriesValues& series) {
  std::vector<double> values;
  for (const auto& [seed, value] : series.by_seed) {
    if (value) values.push_back(*value);
  }
  return values;
}

/// Welch 1947: two means whose variances may differ. Where no seed changes anything, only the
/// number of seeds can vouch for a difference: of all ways to deal them to two runs, two look like
/// this.
struct Welch {
  double difference = 0.0;
  double standard_error = 0.0;
  double degrees = 1.0;
};
Welch welch(double difference, double squared_error_a, double degrees_a, double squared_error_b,
            double degrees_b) {
  const double squared = squared_error_a + squared_error_b;
  Welch result{difference, std::sqrt(squared), degrees_a + degrees_b};
  if (squared > 0.0) {
    result.degrees = squared * squared /
                     (squared_error_a * squared_error_a / degrees_a +
                      squared_error_b * squared_error_b / degrees_b);
  }
  return result;
}

double ways_to_deal(std::size_t a, std::size_t b) {
  return std::exp(std::lgamma(double(a + b) + 1.0) - std::lgamma(double(a) + 1.0) -
                  std::lgamma(double(b) + 1.0));
}

/// The test of `welch` with its effects made by `to_effect`, which rises.
EffectTest student_test(const Welch& at, double smallest_p, std::string how,
                        const std::function<double(double)>& to_effect) {
  EffectTest test;
  test.how = std::move(how);
  test.effect = to_effect(at.difference);
  if (!(at.standard_error > 0.0)) {
    test.smallest_p = smallest_p;
    test.p_value = at.difference == 0.0 ? 1.0 : std::min(1.0, smallest_p);
    test.interval = [at, p = *test.p_value, to_effect](double confidence) {
      const bool sure = at.difference == 0.0 || p <= 1.0 - confidence;
      const double effect = to_effect(at.difference);
      return sure ? Interval{effect, effect, confidence}
                  : Interval{-infinity, infinity, confidence};
    };
    return test;
  }
  const StudentEstimate estimate{at.difference, at.standard_error, at.degrees};
  test.p_value = estimate.p_value(0.0);
  test.interval = [estimate, to_effect](double confidence) {
    const Interval interval = estimate.interval(confidence);
    return Interval{to_effect(interval.low), to_effect(interval.high), confidence};
  };
  return test;
}

EffectTest unpaired(const std::vector<double>& before, const std::vector<double>& after,
                    bool relative) {
  const std::string how =
      fmt::format("other seeds: {} and {}, unpaired", before.size(), after.size());
  const double baseline = mean(before);
  const Welch at = welch(mean(after) - baseline, variance(before) / double(before.size()),
                         double(before.size()) - 1.0, variance(after) / double(after.size()),
                         double(after.size()) - 1.0);
  return student_test(at, 2.0 / ways_to_deal(before.size(), after.size()), how,
                      [baseline, relative](double difference) {
                        return as_effect(difference, baseline, relative);
                      });
}

}  // namespace

SeedTests::SeedTests(std::size_t family)
    : resamples_(int(std::clamp(40.0 * double(family), 9999.0, 99999.0))) {}

EffectTest SeedTests::paired(const std::vector<double>& before, const std::vector<double>& after,
                             bool relative) const {
  std::vector<double> differences;
  for (std::size_t i = 0; i < before.size(); ++i) differences.push_back(after[i] - before[i]);
  auto& bootstrap = made_[before.size()];
  if (!bootstrap) {
    bootstrap =
        std::make_unique<PairedBootstrap>(before.size(), 1, Resampling{.resamples = resamples_});
  }
  EffectTest test;
  const double baseline = mean(before);
  test.effect = as_effect(mean(differences), baseline, relative);
  test.p_value = bootstrap->test(differences).p_value;
  test.smallest_p = bootstrap->smallest_p();
  test.how = fmt::format("{} paired seeds", before.size());
  test.interval = [differences, baseline, relative, tested = bootstrap](double confidence) {
    const Interval interval = tested->interval(differences, confidence);
    return Interval{as_effect(interval.low, baseline, relative),
                    as_effect(interval.high, baseline, relative), confidence};
  };
  return test;
}

EffectTest SeedTests::compare(const SeriesValues& before, const SeriesValues& after) const {
  const bool relative = is_relative(class_of(before.series.metric));
  const std::vector<double> all_before = known_values(before);
  const std::vector<double> all_after = known_values(after);
  if (before.by_seed == after.by_seed && !all_before.empty()) {
    return identical(fmt::format("bit for bit, {} seeds", before.by_seed.size()));
  }
  std::optional<double> effect;
  if (before.value && after.value && std::isfinite(*before.value) && std::isfinite(*after.value)) {
    effect = as_effect(*after.value - *before.value, *before.value, relative);
  }
  if (all_before.size() < before.by_seed.size() || all_after.size() < after.by_seed.size()) {
    return untested(effect, "a seed could not be measured");
  }
  if (!all_finite(all_before) || !all_finite(all_after)) {
    return untested(effect, "a value is infinite");
  }
  std::vector<double> pairs_before;
  std::vector<double> pairs_after;
  for (const auto& [seed, value] : before.by_seed) {
    const auto other = after.by_seed.find(seed);
    if (other == after.by_seed.end()) continue;
    pairs_before.push_back(*value);
    pairs_after.push_back(*other->second);
  }
  if (pairs_before.size() >= 2) return paired(pairs_before, pairs_after, relative);
  if (all_before.size() < 2 || all_after.size() < 2) {
    return untested(effect, "one seed cannot tell a change from its noise");
  }
  return unpaired(all_before, all_after, relative);
}

EffectTest compare_estimates(const SeriesValues& before, const SeriesValues& after) {
  if (before.value && before.value == after.value && before.lower == after.lower &&
      before.upper == after.upper) {
    return identical("bit for bit");
  }
  if (!before.value || !after.value || !(*before.value > 0.0) || !(*after.value > 0.0)) {
    return untested(std::nullopt, "a value is missing or not above 0");
  }
  const double effect = *after.value / *before.value - 1.0;
  std::array<double, 2> squared_errors{};
  std::size_t side = 0;
  for (const SeriesValues* values : {&before, &after}) {
    if (!values->lower || values->n < 2 || !std::isfinite(*values->lower) ||
        !std::isfinite(*values->upper) || !(*values->upper > *values->lower)) {
      return untested(effect, "no interval");
    }
    const StudentEstimate estimate =
        student_estimate(*values->value, 0.5 * (*values->upper - *values->lower), values->n);
    // Of the logarithm, to first order.
    squared_errors[side++] = std::pow(estimate.standard_error / *values->value, 2.0);
  }
  const Welch at = welch(std::log(*after.value / *before.value), squared_errors[0],
                         double(before.n) - 1.0, squared_errors[1], double(after.n) - 1.0);
  return student_test(at, 1.0, "intervals over the seeds", [](double x) { return std::expm1(x); });
}

EffectTest compare_times(const std::vector<double>& before, const std::vector<double>& after,
                         const std::vector<std::vector<double>>& others) {
  if (before == after) return identical(fmt::format("bit for bit, {} runs", before.size()));
  std::vector<std::vector<double>> groups = {before, after};
  groups.insert(groups.end(), others.begin(), others.end());
  double squares = 0.0;
  double degrees = 0.0;
  for (std::vector<double>& group : groups) {
    for (double& time : group) {
      if (!(time > 0.0) || !std::isfinite(time))
        return untested(std::nullopt, "a time is not above 0");
      time = std::log(time);
    }
    if (group.size() < 2) continue;
    squares += variance(group) * (double(group.size()) - 1.0);
    degrees += double(group.size()) - 1.0;
  }
  const double difference = mean(groups[1]) - mean(groups[0]);
  if (degrees < 1.0) {
    return untested(std::expm1(difference),
                    "one run on each side: how much times vary between runs of the same code is "
                    "not known; add repeated runs");
  }
  const double counts = 1.0 / double(before.size()) + 1.0 / double(after.size());
  const Welch at{difference, std::sqrt(squares / degrees * counts), degrees};
  return student_test(
      at, 1.0,
      fmt::format("{} and {} runs, {:g} degrees of freedom", before.size(), after.size(), degrees),
      [](double x) { return std::expm1(x); });
}

}  // namespace occlab::history
