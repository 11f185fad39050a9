#include "harness/comparisons.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <map>

#include "harness/experiment_tables.h"
#include "harness/table_formats.h"
#include "renderers/scene/error.h"
#include "tests/unit/planted_measurements.h"

namespace occlab {
namespace {

/// The only comparison of two methods called a and b.
Comparison compare(const Values& a, const Values& b, const std::string& metric = "rmse") {
  const Comparisons comparisons =
      compare_accuracy(measure({{"a", a}, {"b", b}}, metric), "filtered");
  EXPECT_EQ(comparisons.all.size(), 1u);
  return comparisons.all.at(0);
}

TEST(Comparisons, VerdictsOfPlantedDifferences) {
  const Comparison clear = compare(around(0.2, 0.01), around(0.3, 0.01, 1));
  EXPECT_EQ(clear.verdict, Verdict::less);
  EXPECT_NEAR(*clear.value, -0.1, 1e-12);
  EXPECT_LT(*clear.upper, 0.0);
  EXPECT_NEAR(clear.confidence, 0.95, 1e-12) << "a family of one";
  EXPECT_LT(*clear.adjusted_p, 1e-4);
  EXPECT_EQ(clear.n, 8);
  EXPECT_EQ(better_method(clear), "a");
  EXPECT_EQ(better_method(compare(around(20, 1), around(30, 1, 1), "psnr")), "b");
  EXPECT_EQ(better_method(compare(around(20, 1), around(30, 1, 1), "unheard_of")), "");

  const Comparison unclear = compare(around(0.2, 0.1), around(0.21, 0.1, 1));
  EXPECT_EQ(unclear.verdict, Verdict::unresolved);
  EXPECT_TRUE(*unclear.lower < 0.0 && 0.0 < *unclear.upper);
  EXPECT_EQ(better_method(unclear), "");

  // What both share cancels: the spread of either is a hundred times the difference.
  const Values shared = around(0.0, 10.0);
  Values a = around(0.5, 0.01, 1);
  Values b = around(0.6, 0.01, 2);
  for (std::size_t i = 0; i < 8; ++i) {
    a[i] += shared[i];
    b[i] += shared[i];
  }
  EXPECT_EQ(compare(a, b).verdict, Verdict::less);
}

TEST(Comparisons, EqualIsNotUnresolved) {
  const Comparison same = compare(around(0.2, 0.1), around(0.2, 0.1));
  EXPECT_EQ(same.verdict, Verdict::equal);
  EXPECT_EQ(*same.value, 0.0);
  EXPECT_EQ(*same.lower, 0.0);
  EXPECT_EQ(*same.upper, 0.0);
  EXPECT_EQ(compare(Values(8, infinity), Values(8, infinity), "psnr").verdict, Verdict::equal);
}

TEST(Comparisons, WhatCouldNotBeToldSaysWhy) {
  const Comparison one = compare({0.2}, {0.9});
  EXPECT_EQ(one.verdict, Verdict::unknown);
  EXPECT_EQ(one.reason, "one seed");
  EXPECT_NEAR(*one.value, -0.7, 1e-12);
  EXPECT_FALSE(one.lower || one.adjusted_p);
  EXPECT_EQ(compare({0.2}, {0.2}).reason, "one seed");

  const double nan = std::nan("");
  EXPECT_EQ(compare({0.2, nan, 0.2}, {0.9, 0.8, 0.9}).reason, "a: 3 pixels are NaN");
  EXPECT_FALSE(compare({0.2, nan, 0.2}, {0.9, 0.8, 0.9}).value);
  EXPECT_EQ(compare({0.2, 0.3, 0.2}, {0.9, 0.8}).reason, "measured with different seeds");
  EXPECT_EQ(compare({infinity, 30}, {20, 21}, "psnr").reason, "a value is infinite");
  EXPECT_EQ(compare({}, {20, 21}).reason, "not measured");

  // Two seeds: tested, but nothing two seeds say is certain.
  const Comparison two = compare({0.2, 0.21}, {0.9, 0.92});
  EXPECT_EQ(two.verdict, Verdict::unresolved);
  EXPECT_EQ(*two.upper, infinity);
}

TEST(Comparisons, OnlyUnderTheSameConditions) {
  std::vector<Measurement> rows;
  Measurement m = base("ssao", "rmse");
  add(rows, m, around(0.2, 0.01));
  m.parameters = {{"samples", "8"}};
  add(rows, m, around(0.4, 0.01));
  m = base("ssbn", "rmse");
  m.parameters.emplace_back("cone_angle", "linear");
  add(rows, m, around(0.1, 0.01));
  m.probe = "another";
  add(rows, m, around(0.1, 0.01));
  m = base("ssbn", "rmse");
  m.stage = "unfiltered";
  add(rows, m, around(0.1, 0.01));
  const Comparisons comparisons = compare_accuracy(rows, "filtered");
  ASSERT_EQ(comparisons.all.size(), 1u) << "neither 8 samples nor the other probe or stage";
  EXPECT_EQ(comparisons.all[0].a, "ssao");
  EXPECT_EQ(fact(comparisons.all[0].facts, "samples"), "32");
  EXPECT_EQ(fact(comparisons.all[0].facts, "cone_angle"), "linear");
  EXPECT_EQ(fact(comparisons.all[0].facts, "method"), "");

  rows.push_back(rows.front());
  EXPECT_THROW(compare_accuracy(rows, "filtered"), InputError);
}

// The same two methods, once alone and once among many: a difference that eight seeds resolve at 5%
// is lost in a family of 91, and its interval says so.
TEST(Comparisons, TheWholeTableIsOneFamily) {
  const Values a = around(0.2, 0.1);
  const Values b = around(0.31, 0.1, 1);
  EXPECT_EQ(compare(a, b).verdict, Verdict::less);
  std::map<std::string, Values> many = {{"a", a}, {"b", b}};
  for (std::size_t i = 0; i < 12; ++i) {
    many[fmt::format("m{}", i)] = around(0.25, 0.2, i % 8);
  }
  const Comparisons comparisons = compare_accuracy(measure(many), "filtered");
  EXPECT_EQ(comparisons.tested, 14u * 13u / 2u);
  const Comparison& first = comparisons.all.front();
  EXPECT_EQ(first.a + first.b, "ab");
  EXPECT_EQ(first.verdict, Verdict::unresolved);
  EXPECT_GT(*first.upper, 0.0);
  EXPECT_GT(first.confidence, 0.999);
  EXPECT_GT(*first.adjusted_p, 0.05);
}

TEST(Comparisons, IntervalsSayWhatTheVerdictsSay) {
  std::map<std::string, Values> methods;
  for (std::size_t i = 0; i < 9; ++i) {
    methods[fmt::format("m{}", i)] = around(0.2 + 0.002 * double(i * i), 0.01, i % 8);
  }
  int resolved = 0;
  for (const Comparison& c : compare_accuracy(measure(methods), "filtered").all) {
    if (c.verdict == Verdict::equal) continue;
    const bool excluded = *c.lower > 0.0 || *c.upper < 0.0;
    EXPECT_EQ(excluded, *c.adjusted_p <= 0.05);
    EXPECT_EQ(c.verdict, !excluded      ? Verdict::unresolved
                         : *c.value < 0 ? Verdict::less
                                        : Verdict::greater);
    resolved += excluded ? 1 : 0;
  }
  EXPECT_GT(resolved, 5);
  EXPECT_LT(resolved, 31);
}

TEST(Comparisons, SeveralViewsAreAlsoPooled) {
  std::vector<Measurement> rows;
  const auto add_views = [&](const std::string& method, double value) {
    for (std::size_t view = 0; view < 6; ++view) {
      Measurement m = base(method, "rmse");
      m.view = fmt::format("view{}", view);
      add(rows, m, around(value + 0.01 * double(view * view % 5), 0.01, view));
    }
    Measurement closeup = base(method, "rmse");
    closeup.view = "view0 [corner]";
    add(rows, closeup, around(value, 0.01));
  };
  add_views("a", 0.2);
  add_views("b", 0.5);
  const Comparisons comparisons = compare_accuracy(rows, "filtered");
  ASSERT_EQ(comparisons.all.size(), 8u) << "six views, a closeup and all views";
  const Comparison& pooled = comparisons.all.back();
  EXPECT_EQ(fact(pooled.facts, "view"), "all 6");
  EXPECT_EQ(fact(pooled.facts, "scene"), "gallery");
  EXPECT_NEAR(*pooled.value, -0.3, 1e-12);
  EXPECT_EQ(pooled.verdict, Verdict::less);
  EXPECT_EQ(pooled.row_of_a, "");

  // A view that lacks a seed leaves the others as they are.
  std::erase_if(rows, [](const Measurement& m) { return m.view == "view3" && m.seed == "7"; });
  const Comparisons damaged = compare_accuracy(rows, "filtered");
  EXPECT_EQ(damaged.all.back().verdict, Verdict::unknown);
  EXPECT_EQ(damaged.all.back().reason, "not measured with the same seeds in every view");
  EXPECT_EQ(damaged.all.front().verdict, Verdict::less);
}

Measurement estimate(const std::string& metric, const std::string& method, double value,
                     double lower, double upper, long n = 8) {
  Measurement m = base(method, metric);
  m.seed = "all";
  m.value = value;
  m.lower = lower;
  m.upper = upper;
  m.n = n;
  return m;
}

TEST(Noise, WinnersByRatioAndBySquareOfBias) {
  std::vector<Measurement> rows;
  for (const auto& [method, noise] : {std::pair("a", 0.1), std::pair("b", 0.2)}) {
    rows.push_back(estimate("noise", method, noise, noise - 0.01, noise + 0.01));
    rows.push_back(estimate("bias", method, noise, noise - 0.01, noise + 0.01));
    rows.push_back(estimate("bias_squared", method, noise * noise, 0, 0.1));
    rows.push_back(estimate("mse", method, 2 * noise * noise, 0, 0.1));
  }
  rows.push_back(estimate("noise_ratio.b/a", "b", 2.0, 1.9, 2.1));
  rows.push_back(estimate("bias_squared_difference.b/a", "b", 0.03, 0.02, 0.04));
  const Comparisons comparisons = compare_noise(rows, "filtered");
  ASSERT_EQ(comparisons.tested, 2u);
  EXPECT_EQ(comparisons.all[0].verdict, Verdict::greater);
  EXPECT_TRUE(comparisons.all[0].ratio);
  EXPECT_EQ(better_method(comparisons.all[0]), "a");
  // The second of two tests that are rejected is held to 5% itself.
  const Comparison& later = *comparisons.all[0].adjusted_p > *comparisons.all[1].adjusted_p
                                ? comparisons.all[0]
                                : comparisons.all[1];
  EXPECT_NEAR(later.confidence, 0.95, 1e-12);
  EXPECT_NEAR(*comparisons.all[1].value, 0.03, 1e-15);

  const Table table = noise_table(rows, "filtered", comparisons);
  const auto wins = [&](std::size_t row, std::size_t column) {
    return std::get<TableNumber>(table.rows.at(row).at(column)).winner;
  };
  for (std::size_t column : {1u, 2u, 3u}) {
    EXPECT_TRUE(wins(0, column)) << table.columns[column].name;
    EXPECT_FALSE(wins(1, column));
  }
  EXPECT_FALSE(wins(0, 4)) << "mse has no comparison";

  std::vector<Measurement> wide = rows;
  wide.back().lower = -0.01;
  wide.back().upper = 0.07;
  const Comparisons unresolved = compare_noise(wide, "filtered");
  EXPECT_EQ(unresolved.all[1].verdict, Verdict::unresolved);
  EXPECT_FALSE(std::get<TableNumber>(noise_table(wide, "filtered", unresolved).rows[0][2]).winner);

  wide.back().value.reset();
  wide.back().lower = wide.back().upper = std::nullopt;
  wide.back().reason = "2 and 3 seeds";
  EXPECT_EQ(compare_noise(wide, "filtered").all[1].reason, "2 and 3 seeds");
  wide.pop_back();
  EXPECT_EQ(compare_noise(wide, "filtered").all[1].reason, "not measured");
  EXPECT_TRUE(accuracy_table(rows, "filtered").rows.empty()) << "none of these is an accuracy";
}

TEST(Noise, EstimatesWithoutSpreadOrInterval) {
  const auto judge = [](const Measurement& m) { return compare_ratios({m}).all.at(0); };
  EXPECT_EQ(judge(estimate("rmse_ratio.b/a", "b", 1.0, 1.0, 1.0)).verdict, Verdict::equal);
  EXPECT_EQ(judge(estimate("rmse_ratio.b/a", "b", 1.5, 1.5, 1.5)).verdict, Verdict::greater);
  EXPECT_EQ(judge(estimate("noise_ratio.b/a", "b", 0.0, 0.0, 0.0)).verdict, Verdict::less);
  const Comparison two = judge(estimate("rmse_ratio.b/a", "b", 1.5, 1.5, 1.5, 2));
  EXPECT_EQ(two.verdict, Verdict::unresolved) << "half of all resamples of two seeds are one seed";
  EXPECT_EQ(*two.lower, 0.0);
  EXPECT_EQ(*two.upper, infinity);
  Measurement m = estimate("rmse_ratio.b/a", "b", 1.5, 1.0, 2.0, 1);
  m.lower = m.upper = std::nullopt;
  EXPECT_EQ(judge(m).reason, "one seed");
  m.n = 2;
  EXPECT_EQ(judge(m).reason, "no interval from 2 seeds");
}

// Student's test of the logarithm: with 3 seeds P(|t| > x) = 1 - x / sqrt(2 + x^2).
TEST(Orderings, HoldsAfterHolmsCorrectionOnly) {
  const auto ratio = [](double t) {
    const double half = 4.302652729749464 * 0.1;  // 95%, standard error 0.1
    return estimate("rmse_ratio.b/a", "b", std::exp(0.1 * t), std::exp(0.1 * t - half),
                    std::exp(0.1 * t + half), 3);
  };
  const auto verdicts = [](const std::vector<Measurement>& rows) {
    std::vector<std::string> result;
    for (const auto& row : orderings_table(rows).rows) {
      result.push_back(std::get<std::string>(row.back()));
    }
    return result;
  };
  // p = 0.04 alone; beside p = 0.027 the least of the two misses 0.025 and stops both.
  const double p4 = std::sqrt(2.0) * 0.96 / std::sqrt(1.0 - 0.96 * 0.96);
  const double p27 = std::sqrt(2.0) * 0.973 / std::sqrt(1.0 - 0.973 * 0.973);
  const double p1 = std::sqrt(2.0) * 0.99 / std::sqrt(1.0 - 0.99 * 0.99);
  using Verdicts = std::vector<std::string>;
  EXPECT_EQ(verdicts({ratio(p4)}), Verdicts{"holds"});
  EXPECT_EQ(verdicts({ratio(p4), ratio(p27)}), (Verdicts{"unresolved", "unresolved"}));
  EXPECT_EQ(verdicts({ratio(p4), ratio(-p1)}), (Verdicts{"holds", "does not hold"}));
  const Table table = orderings_table({ratio(p4), ratio(p27)});
  EXPECT_LT(*std::get<TableNumber>(table.rows[1][1]).lower, 1.0) << "as the verdict says";
  EXPECT_NEAR(*compare_ratios({ratio(p4), ratio(-p1)}).all[1].adjusted_p, 0.02, 1e-9);
}

TEST(ComparisonsTable, SaysEverything) {
  const auto rows = measure({{"a", around(0.1, 0.01)},
                             {"b", around(0.3, 0.01, 1)},
                             {"c", around(0.1, 0.01)},
                             {"d", {0.2}}});
  const Table table =
      comparisons_table(compare_accuracy(rows, "filtered"), "comparisons_filtered", "Compared");
  std::vector<std::string> names;
  for (const TableColumn& column : table.columns) names.push_back(column.name);
  EXPECT_EQ(names, (std::vector<std::string>{"metric", "a", "b", "a - b", "unit", "adjusted p",
                                             "verdict", "better"}));
  std::vector<std::string> verdicts;
  for (const auto& row : table.rows) verdicts.push_back(std::get<std::string>(row[6]));
  EXPECT_EQ(verdicts, (std::vector<std::string>{"a < b", "equal", "b > c",
                                                "could not tell: measured with different seeds",
                                                "could not tell: measured with different seeds",
                                                "could not tell: measured with different seeds"}));
  EXPECT_EQ(std::get<std::string>(table.rows[2][7]), "c");
  EXPECT_NE(table.notes.back().find("One family of 3 tests"), std::string::npos);
  for (const std::string& format : table_formats())
    EXPECT_FALSE(format_table(table, format).empty());
  EXPECT_TRUE(comparisons_table({}, "none", "none").rows.empty());
}

// Not pass or fail: how long the tables of 10000 measurements take, drawn resamples included.
TEST(ComparisonsTable, TimeOfTenThousandMeasurements) {
  for (const std::size_t seeds : {8u, 16u}) {
    std::vector<Measurement> rows;
    for (int point = 0; rows.size() < 10000; ++point) {
      for (const char* method : {"ssao", "s3ho", "ssdo", "ssbn"}) {
        for (int metric = 0; metric < 12; ++metric) {
          Measurement m = base(method, fmt::format("metric{}", metric));
          m.parameters = {{"samples", fmt::format("{}", point)}};
          Values values = around(0.1 * point + *(method + 2), 0.3, std::size_t(metric));
          const Values more = around(0.2, 0.1, 1);
          if (seeds == 16) values.insert(values.end(), more.begin(), more.end());
          add(rows, m, values);
        }
      }
    }
    const auto start = std::chrono::steady_clock::now();
    const std::size_t tables = make_tables(rows, {}).size();
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    RecordProperty(fmt::format("seconds_{}_seeds", seeds), fmt::format("{:.3f}", elapsed.count()));
    EXPECT_EQ(tables, 2u);
  }
}

}  // namespace
}  // namespace occlab
