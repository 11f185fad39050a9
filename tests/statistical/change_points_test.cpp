#include "harness/history/change_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "harness/statistics.h"

namespace occlab::history {
namespace {

using Noise = std::function<double(std::mt19937&)>;

std::vector<double> simulate(std::mt19937& random, const Noise& noise, std::size_t n,
                             std::size_t first = 0, double step = 0.0) {
  std::vector<double> values;
  for (std::size_t i = 0; i < n; ++i) {
    values.push_back(100.0 + noise(random) + (step != 0.0 && i >= first ? step : 0.0));
  }
  return values;
}

double normal(std::mt19937& random) { return std::normal_distribution<double>()(random); }
double exponential(std::mt19937& random) { return std::exponential_distribution<double>()(random); }
/// A tenth of the values is 10 times as wide.
double contaminated(std::mt19937& random) {
  return normal(random) * (std::bernoulli_distribution(0.1)(random) ? 10.0 : 1.0);
}

// Each is one z-test; together they raise a false alarm once in 10^5 runs.
TEST(ChangePoints, FalseAlarmsAreTheLevel) {
  constexpr int series = 1000;
  const ChangePointSettings settings{.level = 0.05, .permutations = 399};
  for (const Noise& noise : {Noise(normal), Noise(exponential), Noise(contaminated)}) {
    std::mt19937 random(3);
    int alarms = 0;
    for (int i = 0; i < series; ++i) {
      alarms += find_change_points(simulate(random, noise, 24), settings).empty() ? 0 : 1;
    }
    const double rate = double(alarms) / series;
    const double error = std::sqrt(settings.level * (1.0 - settings.level) / series);
    EXPECT_TRUE(z_test(rate, settings.level, error, 1e-5, 3).passes) << rate;
  }
}

// Of 200 series each: a step of 3 standard deviations is found in at least 90%, with probability
// of a false failure below 1e-6 where the power is 98%.
TEST(ChangePoints, StepsAreFoundWhereTheyAre) {
  std::mt19937 random(5);
  int found = 0;
  double distance = 0.0;
  for (int i = 0; i < 200; ++i) {
    const auto steps = find_change_points(simulate(random, normal, 40, 25, 3.0));
    if (steps.empty()) continue;
    ++found;
    distance += std::abs(double(steps.front().first) - 25.0) / 200.0;
  }
  EXPECT_GE(found, 180);
  EXPECT_LT(distance, 1.0);
}

TEST(ChangePoints, TwoSteps) {
  std::mt19937 random(7);
  std::vector<double> values = simulate(random, normal, 60, 20, 6.0);
  for (std::size_t i = 40; i < 60; ++i) values[i] += 6.0;
  const auto steps = find_change_points(values);
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[0].first, 20u);
  EXPECT_EQ(steps[1].first, 40u);
  EXPECT_NEAR(steps[0].before, 100.0, 1.0);
  EXPECT_NEAR(steps[0].after, 106.0, 1.0);
  EXPECT_TRUE(steps[0].ratio.contains(1.06)) << steps[0].ratio.low << " " << steps[0].ratio.high;
}

TEST(ChangePoints, OneOutlierIsNoStep) {
  std::mt19937 random(9);
  std::vector<double> values = simulate(random, normal, 40);
  values[20] += 1000.0;
  EXPECT_TRUE(find_change_points(values).empty());
}

TEST(ChangePoints, ExactSeriesChangeAtOnce) {
  const std::vector<double> values = {1.0, 1.0, 1.0, 1.0, 1.25};
  const auto steps = find_change_points(values);
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].first, 4u);
  EXPECT_EQ(steps[0].p_value, 0.0);
  EXPECT_DOUBLE_EQ(steps[0].ratio.low, 1.25);
  EXPECT_TRUE(find_change_points(std::vector<double>(10, 2.0)).empty());
}

TEST(ChangePoints, TooFewValuesHaveNone) {
  EXPECT_TRUE(find_change_points({}).empty());
  EXPECT_TRUE(find_change_points(std::vector<double>{1.0}).empty());
  EXPECT_TRUE(find_change_points(std::vector<double>{1.0, 9.0}).empty());
}

}  // namespace
}  // namespace occlab::history
