// From repeated times to medians, ratios and exponents.

#include "harness/timing_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "harness/timing_statistics.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

TEST(TimeRows, MediansQuartilesAndRatios) {
  TaskTimes base;
  base.passes = {{"gbuffer", {1, 1, 1}},
                 {"occlusion", {10, 20, 40}},
                 {"frame", {12, 22, 42}},
                 {"rest", {1, 1, 1}}};
  TaskTimes slower = base;
  slower.passes[1].ms = {11, 24, 40};
  Measurement facts;
  facts.method = "s3ho";
  const std::vector<Measurement> rows = time_rows({facts, slower, base, "", {}});
  const auto find = [&](const std::string& metric) -> const Measurement* {
    const auto row = std::ranges::find(rows, metric, &Measurement::metric);
    return row == rows.end() ? nullptr : &*row;
  };
  EXPECT_DOUBLE_EQ(*find("time_ms.occlusion")->value, 24);
  EXPECT_DOUBLE_EQ(*find("time_ms.occlusion")->lower, 17.5);
  EXPECT_EQ(find("time_ms.occlusion")->unit, "ms");
  EXPECT_NEAR(*find("time_ratio.occlusion")->value, 1.1, 1e-12) << "pair by pair, not 24 / 20";
  EXPECT_NEAR(*find("time_ratio.occlusion")->lower, 1.0, 1e-12);
  EXPECT_NEAR(*find("time_ratio.occlusion")->upper, 1.2, 1e-12);
  EXPECT_EQ(find("time_ratio.occlusion")->n, 3);
  EXPECT_TRUE(find("time_ratio.frame"));
  EXPECT_FALSE(find("time_ratio.gbuffer"));
  EXPECT_FALSE(find("time_ratio.rest"));
  for (const Measurement& row : rows) EXPECT_EQ(row.seed, "all");
}

std::vector<double> repeated(double value, std::size_t count = 5) {
  return std::vector<double>(count, value);
}

TEST(PowerLaw, ExactLawsAreFound) {
  for (const double exponent : {-1.0, 0.0, 0.5, 1.0, 2.0}) {
    std::vector<RepeatedPoint> points;
    for (const double x : {128.0, 4.0, 32.0, 8.0}) {  // in any order
      points.push_back({x, repeated(3.0 * std::pow(x, exponent))});
    }
    const auto law = fit_power_law(points);
    ASSERT_TRUE(law);
    EXPECT_NEAR(law->exponent, exponent, 1e-12);
    EXPECT_EQ(law->points, 4);
    EXPECT_FALSE(law->curved);
    EXPECT_NEAR(law->interval->low, exponent, 1e-9);
    EXPECT_NEAR(law->interval->high, exponent, 1e-9);
  }
}

TEST(PowerLaw, ACommonFactorOfARepetitionCancels) {
  std::vector<RepeatedPoint> points;
  for (const double x : {1.0, 2.0, 4.0}) points.push_back({x, {x, 5.0 * x, 0.1 * x}});
  EXPECT_NEAR(fit_power_law(points)->exponent, 1.0, 1e-12);
  EXPECT_NEAR(fit_power_law(points)->interval->high, 1.0, 1e-9);
}

TEST(PowerLaw, OfAConstantPlusALawTheAsymptoticPart) {
  std::vector<RepeatedPoint> points;
  for (const double x : {1.0, 2.0, 4.0, 8.0, 16.0, 1e4, 2e4, 4e4}) {
    points.push_back({x, {}});
    for (int r = 0; r < 5; ++r) points.back().y.push_back((10.0 + x) * (1.0 + 1e-4 * r * (r - 2)));
  }
  const auto law = fit_power_law(points);
  EXPECT_EQ(law->points, 3);
  EXPECT_NEAR(law->exponent, 1.0, 1e-3);
  EXPECT_FALSE(law->curved);

  points.resize(5);  // bends to the last
  const auto bent = fit_power_law(points);
  EXPECT_EQ(bent->points, 3);
  EXPECT_TRUE(bent->curved);
  EXPECT_LT(bent->exponent, 0.6);
}

TEST(PowerLaw, MissingTimes) {
  std::vector<RepeatedPoint> points = {{1.0, {1.0, std::nan(""), 1.0}}, {2.0, {2.0, 9.0, 2.0}}};
  EXPECT_NEAR(fit_power_law(points)->exponent, 1.0, 1e-12) << "without the second repetition";
  points[1].y = {std::nan(""), 2.0, std::nan("")};
  EXPECT_FALSE(fit_power_law(points));
  points = {{1.0, {1.0}}, {2.0, {4.0}}};
  EXPECT_NEAR(fit_power_law(points)->exponent, 2.0, 1e-12);
  EXPECT_FALSE(fit_power_law(points)->interval) << "one repetition says nothing of its error";
}

TEST(PowerLaw, Refusals) {
  EXPECT_THROW(fit_power_law({{1.0, {1.0}}}), InputError);
  EXPECT_THROW(fit_power_law({{0.0, {1.0}}, {1.0, {1.0}}}), InputError);
  EXPECT_THROW(fit_power_law({{1.0, {1.0}}, {1.0, {1.0}}}), InputError);
  EXPECT_THROW(fit_power_law({{1.0, {0.0}}, {2.0, {1.0}}}), InputError);
  EXPECT_THROW(fit_power_law({{1.0, {1.0}}, {2.0, {1.0, 1.0}}}), InputError);
}

TEST(Exponents, OfEveryAxisMethodAndPass) {
  std::vector<TimedSeries> all;
  for (const char* method : {"ssao", "s3ho"}) {
    for (const double x : {8.0, 16.0, 32.0}) {
      TimedSeries series;
      series.facts.method = method;
      series.times.passes = {{"occlusion", repeated(method[1] == 's' ? x : x * x)},
                             {"frame", repeated(5.0)},
                             {"rest", repeated(1.0)}};
      series.axes = {{"samples", x}};
      if (x == 8.0) series.axes.emplace_back("steps", 2.0);
      all.push_back(series);
    }
  }
  const Exponents exponents = fit_exponents(all, {});
  const auto find = [&](const char* method, const std::string& metric) {
    const auto row = std::ranges::find_if(exponents.rows, [&](const Measurement& m) {
      return m.method == method && m.metric == metric;
    });
    return row == exponents.rows.end() ? Measurement() : *row;
  };
  EXPECT_NEAR(*find("ssao", "time_exponent.samples.occlusion").value, 1.0, 1e-9);
  EXPECT_NEAR(*find("s3ho", "time_exponent.samples.occlusion").value, 2.0, 1e-9);
  EXPECT_NEAR(*find("s3ho", "time_exponent.samples.frame").value, 0.0, 1e-9);
  EXPECT_EQ(find("ssao", "time_exponent.steps.occlusion").reason, "one point only");
  EXPECT_EQ(find("ssao", "time_exponent.samples.rest").metric, "") << "the rest is no work";
}

TEST(MedianInterval, ByHand) {
  // n = 6: from the smallest to the largest covers 1 - 2/64, the next 1 - 14/64.
  const std::vector<double> six = {6, 2, 4, 1, 5, 3};
  const double share = (62.0 / 64 - 0.95) / (12.0 / 64);
  const double weight = 5 * share / (1 + 4 * share);
  EXPECT_NEAR(interpolated_median_interval(six).low, 1 + weight, 1e-12);
  EXPECT_NEAR(interpolated_median_interval(six).high, 6 - weight, 1e-12);
  const Interval three = interpolated_median_interval(std::vector<double>{3, 1, 2});
  EXPECT_EQ(three.low, 1);
  EXPECT_EQ(three.high, 3);
  EXPECT_DOUBLE_EQ(three.confidence, 0.75);
  EXPECT_EQ(interpolated_median_interval(std::vector<double>{5}).confidence, 0.0);
  EXPECT_THROW(interpolated_median_interval({}), InputError);
  EXPECT_THROW(interpolated_median_interval(six, 1.0), InputError);
}

}  // namespace
}  // namespace occlab
