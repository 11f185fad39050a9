#include "harness/history/gate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "harness/history/gate_formats.h"
#include "renderers/scene/error.h"

namespace occlab::history {
namespace {

/// A method's metric with the seeds' values around `level`.
SeriesValues metric(const std::string& name, double level, double spread, unsigned noise_seed,
                    int seeds = 8, int first_seed = 0) {
  SeriesValues values;
  values.series = {"small", "boxes",    "main", "16x9", "sun", "ssao",
                   {},      "filtered", name,   "1",    "gl"};
  std::mt19937 random(noise_seed);
  std::normal_distribution<double> normal;
  double sum = 0.0;
  for (int seed = 0; seed < seeds; ++seed) {
    const double value = level + spread * normal(random);
    values.by_seed[first_seed + seed] = value;
    sum += value;
  }
  values.value = sum / seeds;
  values.n = seeds;
  return values;
}

SeriesValues time_ratio(double value, const std::string& device = "gl") {
  SeriesValues values;
  values.series = {"small", "boxes", "main", "16x9", "sun", "s3ho", {}, "", "time_ratio.occlusion",
                   "",      device};
  values.value = value;
  values.lower = 0.99 * value;
  values.upper = 1.01 * value;
  values.n = 9;
  return values;
}

RunData run(std::vector<SeriesValues> series) {
  RunData data;
  data.name = "run";
  data.facts.experiment = "small";
  data.facts.device = "gl";
  data.series = std::move(series);
  return data;
}

GateReport gate(const SeriesValues& before, const SeriesValues& after, GateSettings settings = {}) {
  return run_gate({{run({before})}}, {{run({after})}}, {}, settings);
}

Outcome outcome(const SeriesValues& before, const SeriesValues& after) {
  return gate(before, after).findings.at(0).outcome;
}

SeriesValues shifted(SeriesValues values, double factor, double jitter = 0.0) {
  double sign = 1.0;
  for (auto& [seed, value] : values.by_seed) {
    value = *value * (factor + jitter * sign);
    sign = -sign * 0.9;
  }
  values.value = *values.value * factor;
  return values;
}

TEST(Gate, EqualBitForBitIsSame) {
  const SeriesValues before = metric("rmse", 0.2, 0.01, 1);
  const GateReport report = gate(before, before);
  EXPECT_EQ(report.findings.at(0).outcome, Outcome::same);
  EXPECT_EQ(report.findings.at(0).effect, 0.0);
  EXPECT_EQ(exit_code(report, {}), exit_good);
  // So it is with one seed.
  EXPECT_EQ(outcome(metric("rmse", 0.2, 0.0, 1, 1), metric("rmse", 0.2, 0.0, 1, 1)), Outcome::same);
}

TEST(Gate, DirectionsDecide) {
  for (const auto& [name, up, down] :
       {std::tuple("rmse", Outcome::worse, Outcome::better),
        std::tuple("ssim", Outcome::better, Outcome::worse),
        std::tuple("psnr", Outcome::better, Outcome::worse),
        std::tuple("unheard_of", Outcome::changed, Outcome::changed)}) {
    const SeriesValues before = metric(name, 10.0, 0.5, 1);
    EXPECT_EQ(outcome(before, shifted(before, 1.1, 0.001)), up) << name;
    EXPECT_EQ(outcome(before, shifted(before, 0.9, 0.001)), down) << name;
  }
}

TEST(Gate, WorseFailsAndBetterDoesNot) {
  const SeriesValues before = metric("rmse", 0.2, 0.01, 1);
  EXPECT_EQ(exit_code(gate(before, shifted(before, 1.1, 0.001)), {}), exit_check_failed);
  EXPECT_EQ(exit_code(gate(before, shifted(before, 0.9, 0.001)), {}), exit_good);
}

TEST(Gate, SmallButSignificantIsSame) {
  const SeriesValues before = metric("rmse", 0.2, 0.01, 1);
  const GateReport report = gate(before, shifted(before, 1.01, 0.0005));
  EXPECT_EQ(report.findings.at(0).outcome, Outcome::same);
  EXPECT_LT(*report.findings.at(0).adjusted_p, 0.01);
  GateSettings fine;
  fine.minimum.error = 0.005;
  EXPECT_EQ(gate(before, shifted(before, 1.01, 0.0005), fine).findings.at(0).outcome,
            Outcome::worse);
}

TEST(Gate, WhatNoiseHidesIsUnsure) {
  const SeriesValues before = metric("rmse", 0.2, 0.05, 1);
  const SeriesValues after = metric("rmse", 0.2, 0.05, 2);
  const GateReport report = gate(before, after);
  EXPECT_EQ(report.findings.at(0).outcome, Outcome::unsure);
  EXPECT_FALSE(report.findings.at(0).reason.empty());
  EXPECT_EQ(exit_code(report, {}), exit_good);
  GateSettings strict;
  strict.strict = true;
  EXPECT_EQ(exit_code(report, strict), exit_check_failed);
}

TEST(Gate, OtherSeedsAreComparedUnpaired) {
  const SeriesValues before = metric("rmse", 0.2, 0.0005, 1);
  const SeriesValues after = metric("rmse", 0.2, 0.0005, 2, 8, 100);
  const GateReport report = gate(before, after);
  EXPECT_EQ(report.findings.at(0).outcome, Outcome::same);
  EXPECT_NE(report.findings.at(0).how.find("unpaired"), std::string::npos);
  EXPECT_EQ(outcome(before, metric("rmse", 0.3, 0.0005, 2, 8, 100)), Outcome::worse);
}

TEST(Gate, OneSeedTellsNothing) {
  const GateReport report = gate(metric("rmse", 0.2, 0.0, 1, 1), metric("rmse", 0.4, 0.0, 1, 1));
  EXPECT_EQ(report.findings.at(0).outcome, Outcome::unsure);
  EXPECT_EQ(report.compared(), 0u);
  EXPECT_EQ(exit_code(report, {}), exit_bad_input);
  EXPECT_NE(summary(report, {}).find("one seed"), std::string::npos);
}

TEST(Gate, NothingToCompareNeverPasses) {
  SeriesValues other = metric("rmse", 0.2, 0.01, 1);
  other.series.scene = "elsewhere";
  const GateReport report = gate(metric("rmse", 0.2, 0.01, 1), other);
  EXPECT_EQ(exit_code(report, {}), exit_bad_input);
  GateSettings lenient;
  lenient.allow_missing = true;
  EXPECT_EQ(exit_code(report, lenient), exit_bad_input);
  EXPECT_NE(summary(report, {}).find("scene: 'elsewhere' here, 'boxes' in the baseline"),
            std::string::npos);
  EXPECT_EQ(exit_code(run_gate({{run({})}}, {{run({other})}}, {}, {}), {}), exit_bad_input);
}

TEST(Gate, MissingSeriesFailUnlessAllowed) {
  const SeriesValues rmse = metric("rmse", 0.2, 0.01, 1);
  const SeriesValues ssim = metric("ssim", 0.9, 0.01, 1);
  const GateReport report = run_gate({{run({rmse, ssim})}}, {{run({rmse})}}, {}, {});
  EXPECT_EQ(report.findings.at(0).outcome, Outcome::missing);
  EXPECT_EQ(report.findings.at(0).series.metric, "ssim");
  EXPECT_EQ(exit_code(report, {}), exit_check_failed);
  GateSettings lenient;
  lenient.allow_missing = true;
  EXPECT_EQ(exit_code(report, lenient), exit_good);
}

TEST(Gate, OtherInputsFailUnlessAllowed) {
  const SeriesValues rmse = metric("rmse", 0.2, 0.01, 1);
  RunData before = run({rmse});
  RunData after = run({rmse});
  before.facts.run = {{"probe", {{"sha256", "aaaa"}}}, {"scene", {{"sha256", "cccc"}}}};
  after.facts.run = {{"probe", {{"sha256", "bbbb"}}}, {"scene", {{"sha256", "cccc"}}}};
  GateSettings settings;
  const GateReport report = run_gate({{before}}, {{after}}, {}, settings);
  EXPECT_EQ(report.inputs.size(), 1u);
  EXPECT_EQ(exit_code(report, settings), exit_check_failed);
  settings.allow_changed_inputs = true;
  EXPECT_EQ(exit_code(report, settings), exit_good);
}

TEST(Gate, FewSeedsAreSaid) {
  const SeriesValues before = metric("rmse", 0.2, 0.01, 1, 2);
  const GateReport report = gate(before, shifted(before, 1.5, 0.001));
  EXPECT_EQ(report.findings.at(0).outcome, Outcome::unsure);
  ASSERT_FALSE(report.notes.empty());
  EXPECT_NE(report.notes[0].find("Too few seeds"), std::string::npos);
  // No change whatever could have been told: that is no comparison.
  EXPECT_EQ(report.compared(), 0u);
  EXPECT_EQ(report.findings.at(0).reason, "too few seeds");
  EXPECT_EQ(exit_code(report, {}), exit_bad_input);
}

TEST(Gate, EveryRunOfTheBaselineCounts) {
  const SeriesValues rmse = metric("rmse", 0.2, 0.01, 1);
  const SeriesValues ratio = time_ratio(1.1);
  const auto judged = [&](const GateSide& before, const GateSide& after) {
    return run_gate(before, after, {}, {});
  };
  // A series that only the second run has is missed where the results do not have it.
  const GateReport missing = judged({{run({rmse}), run({rmse, ratio})}}, {{run({rmse})}});
  EXPECT_EQ(missing.count(Outcome::missing), 1u);
  // An input of the second run is looked at, too.
  RunData first = run({rmse});
  RunData second = first;
  first.facts.run = {{"scene", {{"name", "boxes"}, {"sha256", "aaaa"}}}};
  second.facts.run = {{"scene", {{"name", "boxes"}, {"sha256", "bbbb"}}}};
  EXPECT_EQ(judged({{first}}, {{first, second}}).inputs.size(), 1u);
  EXPECT_EQ(judged({{first}}, {{first, first}}).inputs.size(), 0u);
  // So are those of a run of several scenes.
  second.facts.run = {{"benches", {{{"scene", {{"name", "boxes"}, {"sha256", "bbbb"}}}}}}};
  EXPECT_EQ(judged({{first}}, {{second}}).inputs.size(), 1u);
}

TEST(Gate, TimesNeedRepeatedRuns) {
  const GateReport single = gate(time_ratio(1.1), time_ratio(1.3));
  EXPECT_EQ(single.findings.at(0).outcome, Outcome::unsure);
  EXPECT_EQ(exit_code(single, {}), exit_bad_input);
  const auto runs = [](std::initializer_list<double> ratios) {
    GateSide side;
    for (const double ratio : ratios) side.runs.push_back(run({time_ratio(ratio)}));
    return side;
  };
  const GateSide before = runs({1.10, 1.11, 1.09, 1.10});
  const auto verdict = [&](const GateSide& after) {
    return run_gate(before, after, {}, {}).findings.at(0).outcome;
  };
  EXPECT_EQ(verdict(runs({1.22, 1.21, 1.23})), Outcome::worse);
  EXPECT_EQ(verdict(runs({1.00, 0.99, 1.01})), Outcome::better);
  EXPECT_EQ(verdict(runs({1.10, 1.105, 1.095})), Outcome::same);
  EXPECT_EQ(verdict(runs({1.10, 1.40, 1.00})), Outcome::unsure);
  // What is learnt from the repeated runs of another commit serves a single one.
  const std::vector<std::vector<RunData>> others = {runs({2.0, 2.02, 1.98, 2.0, 2.01}).runs};
  EXPECT_EQ(run_gate(runs({1.1}), runs({1.3}), others, {}).findings.at(0).outcome, Outcome::worse);
  // Results that were added to the history before they are checked do not vouch for themselves.
  GateSide added = runs({1.3, 1.5});
  int number = 0;
  for (RunData& data : added.runs) data.facts.run = {{"number", ++number}};
  const auto degrees = [&](const std::vector<std::vector<RunData>>& groups) {
    return run_gate(runs({1.1}), added, groups, {}).findings.at(0).how;
  };
  EXPECT_NE(degrees({}).find("1 degrees of freedom"), std::string::npos) << degrees({});
  EXPECT_EQ(degrees({added.runs}), degrees({}));
}

TEST(Gate, TimesOfOtherMachinesAreNotCompared) {
  const GateReport report = gate(time_ratio(1.1, "gl"), time_ratio(1.1, "other gl"));
  EXPECT_EQ(report.findings.at(0).outcome, Outcome::unsure);
  EXPECT_NE(report.findings.at(0).reason.find("another device"), std::string::npos);
}

TEST(Gate, AMethodsRatioToItselfIsNoComparison) {
  SeriesValues itself = time_ratio(1.0);
  itself.lower = itself.upper = 1.0;
  EXPECT_TRUE(gate(itself, itself).findings.empty());
}

TEST(Gate, ErrorsKnowTheirNoiseFloor) {
  SeriesValues floor = metric("reference_interval", 0.01, 0.0, 1);
  floor.series.method = "rtdo";
  const SeriesValues rmse = metric("rmse", 0.2, 0.01, 1);
  const GateReport report = run_gate({{run({rmse, floor})}}, {{run({rmse, floor})}}, {}, {});
  ASSERT_EQ(report.findings.size(), 1u);
  EXPECT_EQ(report.findings[0].floor, floor.value);
}

TEST(GateFormats, JunitIsWellFormedWhateverNamesHold) {
  SeriesValues before = metric("rmse", 0.2, 0.01, 1);
  before.series.scene = "<a & \"b\">\x01";
  const GateReport report = gate(before, shifted(before, 1.2, 0.001));
  const std::string xml = gate_junit(report, {});
  EXPECT_NE(xml.find("&lt;a &amp; &quot;b&quot;&gt;?"), std::string::npos);
  EXPECT_NE(xml.find("tests=\"1\" failures=\"1\""), std::string::npos);
  EXPECT_EQ(xml.find('\x01'), std::string::npos);
}

TEST(GateFormats, JsonHasInfinitiesAsText) {
  const SeriesValues before = metric("rmse", 0.0, 0.0, 1);
  SeriesValues after = metric("rmse", 0.1, 0.01, 1);
  const nlohmann::json json = gate_json(gate(before, after), {});
  EXPECT_EQ(json["findings"][0]["verdict"], "WORSE");
  EXPECT_EQ(json["findings"][0]["effect"], "inf");
  EXPECT_EQ(json["exit_code"], 1);
}

TEST(GateFormats, MarkdownHasTheWorstFirst) {
  const SeriesValues rmse = metric("rmse", 0.2, 0.01, 1);
  const SeriesValues ssim = metric("ssim", 0.9, 0.01, 1);
  const GateReport report =
      run_gate({{run({ssim, rmse})}}, {{run({ssim, shifted(rmse, 1.2, 0.001)})}}, {}, {});
  const std::string markdown = gate_markdown(report, {});
  EXPECT_NE(markdown.find("FAILED: 1 WORSE, 1 SAME"), std::string::npos);
  EXPECT_LT(markdown.find("| WORSE"), markdown.find("<details>"));
  EXPECT_GT(markdown.find("| SAME"), markdown.find("<details>"));
}

TEST(MinimumEffects, UnknownOnesAreRefused) {
  MinimumEffects effects;
  effects.set("time", 0.1, "x");
  EXPECT_EQ(effects.of(class_of("time_ratio.occlusion")), 0.1);
  EXPECT_THROW(effects.set("tim", 0.1, "x"), InputError);
  EXPECT_THROW(effects.set("time", 0.0, "x"), InputError);
  EXPECT_THROW(effects.set("time", -1.0, "x"), InputError);
}

}  // namespace
}  // namespace occlab::history
