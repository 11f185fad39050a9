#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>

#include "claim_measurements.h"
#include "harness/claims/claim_file.h"
#include "harness/claims/claim_tables.h"
#include "harness/claims/claim_terms.h"
#include "harness/claims/record.h"
#include "harness/files.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

ClaimStatement parse(const std::string& text, const ClaimVariables& variables = {}) {
  std::set<std::string> used;
  return parse_statement(text, variables, used);
}

TEST(Statement, LeftOverRight) {
  const ClaimStatement s = parse("noise(ssdo, 32) > 2 * noise(s3ho, samples=16, stage=filtered)");
  ASSERT_EQ(s.quantity.factors.size(), 2U);
  EXPECT_EQ(s.quantity.factors[0].power, 1);
  EXPECT_EQ(s.quantity.factors[1].power, -1);
  EXPECT_EQ(s.quantity.factors[0].term.metric, "noise");
  EXPECT_EQ(*s.quantity.factors[0].term.filter("samples"), "32");
  EXPECT_EQ(*s.quantity.factors[1].term.filter("stage"), "filtered");
  EXPECT_EQ(s.low, 2.0);
  EXPECT_EQ(s.high, infinity);
}

TEST(Statement, Relations) {
  EXPECT_EQ(parse("4 * rmse(a, 8) < rmse(b, 8)").high, 0.25);
  EXPECT_EQ(parse("rmse(a, 8) < rmse(b, 8)").low, 0.0);
  const ClaimStatement like = parse("rmse(a, 8) ~ rmse(b, 8) within 25%");
  EXPECT_DOUBLE_EQ(like.low, 0.8);
  EXPECT_DOUBLE_EQ(like.high, 1.25);
  const ClaimStatement in = parse("rmse(a, 8) / rmse(b, 8) in [0.5, 3]");
  EXPECT_EQ(in.low, 0.5);
  EXPECT_EQ(in.high, 3.0);
}

TEST(Statement, ProductsAndShortNames) {
  const ClaimStatement s = parse("time(a, 8) / time.frame(b) * rmse(c) > 1");
  EXPECT_EQ(s.quantity.factors[0].term.metric, "time_ms.occlusion");
  EXPECT_EQ(s.quantity.factors[1].term.metric, "time_ms.frame");
  EXPECT_EQ(s.quantity.factors[2].power, 1);
  EXPECT_EQ(to_string(s.quantity), "time.occlusion(a, 8) * rmse(c) / time.frame(b)");
}

TEST(Statement, VariablesAndQuotes) {
  const ClaimStatement s =
      parse("rmse(M, N, closeup='90-degree corner') < rmse(b, N)", {{"N", "32"}, {"M", "s3ho"}});
  EXPECT_EQ(s.quantity.factors[0].term.method, "s3ho");
  EXPECT_EQ(*s.quantity.factors[1].term.filter("samples"), "32");
  EXPECT_EQ(*s.quantity.factors[0].term.filter("closeup"), "90-degree corner");
}

TEST(Statement, ErrorsNameThePlaceAndWhatIsAccepted) {
  const std::vector<std::array<std::string, 3>> wrong = {
      {"noise(ssdo 32) > 1", "character 12", "',' or ')'"},
      {"noise(ssdo, 32)", "character 16", "found the end"},
      {"noise(ssdo, 32) >", "found the end", "a metric"},
      {"noise(ssdo, 32) = 2", "found '='", "'>', '<', '~' or 'in'"},
      {"noise(a) ~ noise(b)", "found the end", "'within'"},
      {"noise(a) ~ noise(b) within 5", "found the end", "'%'"},
      {"noise(a) in [2, 1]", "found ']'", "a number above 2"},
      {"noise(a) > 1 2", "found '2'", "the end"},
      {"noise(a) > 0", "found '0'", "a number above 0"},
      {"noise(a) in (1, 2)", "found '('", "'['"},
      {"noise() > 1", "found ')'", "a method"},
      {"noise(a, 8, samples=9) > 1", "'samples' is there twice", ""},
      {"noise(a, x='y) > 1", "found ''y) > 1'", "a second quote"},
      {"2 > 1", "no measurement in it", ""},
      {"noise(a, 8) > noise(a, 8)", "divided by itself", ""},
  };
  for (const auto& [text, first, second] : wrong) {
    const std::string message = message_of([&, &statement = text] { parse(statement); });
    EXPECT_NE(message.find(first), std::string::npos) << text << ": " << message;
    EXPECT_NE(message.find(second), std::string::npos) << text << ": " << message;
  }
}

TEST(Terms, RefuseWhatCannotBeMeasured) {
  const auto message = [](const std::string& text) {
    return message_of([&] {
      const ClaimStatement statement = parse(text);
      for (const ClaimFactor& factor : statement.quantity.factors) {
        check_term(factor.term, methods());
      }
      check_statement(statement);
    });
  };
  const std::vector<std::array<std::string, 2>> wrong = {
      {"nois(ssao, 8, stage=filtered) > 1", "did you mean 'noise'"},
      {"noise(s3h, 8, stage=filtered) > 1", "did you mean 's3ho'"},
      {"noise(ssao, 8, stag=filtered) > 1", "did you mean 'stage'"},
      {"noise(ssao, 8, stage=both) > 1", "unfiltered, filtered"},
      {"noise(ssao, 8) > 1", "stage missing"},
      {"time(ssao, 8, stage=filtered) > 1", "times do not have"},
      {"noise(ssao, N, stage=filtered) > 1", "samples"},
      {"noise(ssao, 8, seed=1, stage=filtered) > 1", "unknown filter 'seed'"},
      {"psnr(ssao, 8, stage=filtered) > 1", "mean nothing"},
      {"noise(ssao, 8, stage=filtered) > time(ssao, 8)", "not of a kind"},
      {"bias_squared(ssao, 8, stage=filtered) > 1", "accepted: a statement 'a > b'"},
      {"bias_squared(ssao, 8, stage=filtered) > 2 * bias_squared(s3ho, 8, stage=filtered)",
       "accepted: a statement 'a > b'"},
  };
  for (const auto& [text, words] : wrong) {
    EXPECT_NE(message(text).find(words), std::string::npos) << text << ": " << message(text);
  }
  EXPECT_EQ(
      message("bias_squared(ssao, 8, stage=filtered) < bias_squared(s3ho, 8, stage=filtered)"),
      "no error");
}

TEST(Terms, SelectRowsByColumnsAndParameters) {
  Measurement row = claim_row("s3ho", "rmse");
  row.probe = "cathedral, filtered 8 deg";
  const auto fits = [&](const std::string& text) {
    return selects(parse(text + " > 1").quantity.factors.front().term, row);
  };
  EXPECT_TRUE(fits("rmse(s3ho, 32)"));
  EXPECT_TRUE(fits("rmse(s3ho, 32.0, probe=cathedral)"));
  EXPECT_FALSE(fits("rmse(s3ho, 32, probe=cath)"));
  EXPECT_FALSE(fits("rmse(s3ho, 16)"));
  EXPECT_FALSE(fits("rmse(ssao, 32)"));
  EXPECT_FALSE(fits("noise(s3ho, 32)"));
  EXPECT_FALSE(fits("rmse(s3ho, 32, view=other)"));
  EXPECT_FALSE(fits("rmse(s3ho, 32, closeup=corner)"));
  row.view = "main [corner]";
  EXPECT_FALSE(fits("rmse(s3ho, 32)"));
  EXPECT_TRUE(fits("rmse(s3ho, 32, closeup=corner, view=main)"));
}

// --- estimates of planted measurements -----------------------------------------------------------

TEST(Estimate, AccuraciesArePairedBySeed) {
  // Noise that both share cancels: the ratio is 2 for every seed.
  const Values one = around(1.0, 0.3);
  Values two = one;
  for (double& value : two) value *= 2.0;
  std::vector<Measurement> rows;
  plant(rows, "ssdo", "rmse", two);
  plant(rows, "s3ho", "rmse", one);
  const JudgedClaim judged = judge_one("rmse(ssdo, 32) > 1.9 * rmse(s3ho, 32)", rows);
  EXPECT_EQ(judged.verdict, ClaimVerdict::ordering);
  EXPECT_NEAR(judged.cases[0].estimate->value, 2.0, 1e-12);
  EXPECT_NEAR(judged.cases[0].interval->low, 2.0, 1e-6);
  EXPECT_EQ(judge_one("rmse(ssdo, 32) > 2.1 * rmse(s3ho, 32)", rows).verdict,
            ClaimVerdict::not_reproduced);
}

TEST(Estimate, VerdictsOfAKnownRatio) {
  std::vector<Measurement> rows;
  plant(rows, "ssdo", "rmse", around(1.5, 0.05, 0));
  plant(rows, "s3ho", "rmse", around(1.0, 0.05, 3));
  const auto outcome = [&](const std::string& text) {
    return judge_one(text, rows).cases.front().outcome;
  };
  EXPECT_EQ(outcome("rmse(ssdo, 32) > rmse(s3ho, 32)"), CaseOutcome::holds);
  EXPECT_EQ(outcome("rmse(ssdo, 32) < rmse(s3ho, 32)"), CaseOutcome::contradicted);
  EXPECT_EQ(outcome("rmse(ssdo, 32) ~ rmse(s3ho, 32) within 80%"), CaseOutcome::holds);
  EXPECT_EQ(outcome("rmse(ssdo, 32) ~ rmse(s3ho, 32) within 50%"), CaseOutcome::unresolved);
  EXPECT_EQ(outcome("rmse(ssdo, 32) ~ rmse(s3ho, 32) within 20%"), CaseOutcome::contradicted);
  EXPECT_EQ(outcome("rmse(ssdo, 32) / rmse(s3ho, 32) in [1.3, 1.7]"), CaseOutcome::holds);
  EXPECT_EQ(outcome("rmse(ssdo, 32) > 1.5 * rmse(s3ho, 32)"), CaseOutcome::unresolved);
}

TEST(Estimate, NoiseUsesTheStoredPairWhereThereIsOne) {
  std::vector<Measurement> rows;
  plant_estimate(rows, "ssdo", "noise", 3.0, 2.0, 4.5, {"a"});
  plant_estimate(rows, "s3ho", "noise", 1.5, 1.0, 2.25, {"b"});
  const std::string text = "noise(ssdo, 32) > noise(s3ho, 32)";
  const JudgedClaim apart = judge_one(text, rows);
  // Added standard errors: each has half a logarithm of log(1.5).
  EXPECT_NEAR(apart.cases[0].interval->high, 2.0 * 2.25, 1e-6);
  EXPECT_EQ(apart.verdict, ClaimVerdict::not_reproduced);
  plant_estimate(rows, "ssdo", "noise_ratio.ssdo/s3ho", 2.0, 1.8, 2.0 / 1.8 * 2.0, {"a", "b"});
  const JudgedClaim paired = judge_one(text, rows);
  EXPECT_EQ(paired.verdict, ClaimVerdict::ordering);
  EXPECT_NEAR(paired.cases[0].interval->low, 1.8, 1e-6);
  // The same pair the other way round.
  const JudgedClaim inverse = judge_one("noise(s3ho, 32) < noise(ssdo, 32)", rows);
  EXPECT_NEAR(inverse.cases[0].interval->high, 1.0 / 1.8, 1e-6);
  EXPECT_EQ(inverse.verdict, ClaimVerdict::ordering);
}

TEST(Estimate, TimesGoThroughTheBaseline) {
  std::vector<Measurement> rows;
  plant_time(rows, "ssao", 10.0, 1.0, 1.0, 1.0);
  plant_time(rows, "s3ho", 11.0, 1.1, 1.08, 1.12);
  plant_time(rows, "ssdo", 15.0, 1.5, 1.45, 1.55);
  const JudgedClaim direct = judge_one("time(s3ho, 32) / time(ssao, 32) in [1, 1.15]", rows);
  EXPECT_EQ(direct.verdict, ClaimVerdict::ordering);
  EXPECT_NEAR(direct.cases[0].interval->low, 1.08, 1e-9);
  EXPECT_NEAR(direct.cases[0].interval->high, 1.12, 1e-9);
  const JudgedClaim both = judge_one("time(ssdo, 32) > time(s3ho, 32)", rows);
  EXPECT_NEAR(both.cases[0].estimate->value, 1.5 / 1.1, 1e-9);
  EXPECT_NEAR(both.cases[0].interval->low, 1.45 / 1.12, 1e-9);
  EXPECT_NEAR(both.cases[0].interval->high, 1.55 / 1.08, 1e-9);
}

TEST(Estimate, DifferencesOfTheSquaredBias) {
  std::vector<Measurement> rows;
  plant_estimate(rows, "s3ho", "bias_squared", 0.04, 0.03, 0.05, {"a"});
  plant_estimate(rows, "ssdo", "bias_squared", -0.01, -0.02, 0.0, {"b"});
  plant_estimate(rows, "ssdo", "bias_squared_difference.ssdo/s3ho", -0.05, -0.06, -0.04,
                 {"a", "b"});
  const JudgedClaim judged = judge_one("bias_squared(s3ho, 32) > bias_squared(ssdo, 32)", rows);
  EXPECT_EQ(judged.verdict, ClaimVerdict::ordering);
  EXPECT_TRUE(judged.cases[0].estimate->difference);
  EXPECT_NEAR(judged.cases[0].interval->low, 0.04, 1e-9);
  EXPECT_EQ(judge_one("bias_squared(s3ho, 32) < bias_squared(ssdo, 32)", rows).cases[0].outcome,
            CaseOutcome::contradicted);
}

TEST(Estimate, SaysWhyItCannot) {
  std::vector<Measurement> rows;
  plant(rows, "ssdo", "rmse", around(1.0, 0.1));
  plant(rows, "s3ho", "rmse", {1.0, 1.1, 0.9});
  plant(rows, "ssbn", "rmse", {1.0});
  plant(rows, "ssao", "rmse", {0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0});
  plant(rows, "rtdo", "rmse", {1.0, 1.0, std::nan(""), 1.0, 1.0, 1.0, 1.0, 1.0});
  const auto reason = [&](const std::string& text) {
    const JudgedClaim judged = judge_one(text, rows);
    EXPECT_EQ(judged.verdict, ClaimVerdict::untestable);
    return judged.reason;
  };
  EXPECT_NE(reason("rmse(ssdo, 16) > 1").find("made by 'occlab run x.toml'"), std::string::npos);
  EXPECT_NE(reason("rmse(ssdo, 32) > rmse(s3ho, 32)").find("different seeds"), std::string::npos);
  EXPECT_NE(reason("rmse(ssbn, 32) > 1").find("one seed"), std::string::npos);
  EXPECT_NE(reason("rmse(ssao, 32) > 1").find("above 0"), std::string::npos);
  EXPECT_NE(reason("rmse(rtdo) > 1").find("3 pixels are NaN"), std::string::npos);
}

TEST(Estimate, RefusesTermsThatFitSeveralRows) {
  std::vector<Measurement> rows;
  plant(rows, "ssdo", "rmse", around(1.0, 0.1));
  for (Measurement row : std::vector<Measurement>(rows)) {
    row.probe = "sky";
    rows.push_back(row);
  }
  const std::string message = message_of([&] { judge_one("rmse(ssdo, 32) > 1", rows); });
  EXPECT_NE(message.find("several measurements fit"), std::string::npos) << message;
  EXPECT_NE(message.find("probe is 'cathedral' in one and 'sky' in another"), std::string::npos)
      << message;
}

// --- verdicts
// -------------------------------------------------------------------------------------

TEST(Verdict, ValueNeedsTheNumberAndAnIntervalThatCanTell) {
  std::vector<Measurement> rows;
  plant_time(rows, "ssao", 10.0, 1.0, 1.0, 1.0);
  plant_time(rows, "s3ho", 11.0, 1.1, 1.08, 1.12);
  const auto verdict = [&](double published, double tolerance, double precision) {
    Claim claim = value_claim("time(s3ho, 32) / time(ssao, 32)", published);
    claim.tolerance = tolerance;
    claim.precision = precision;
    return judge(claim, rows);
  };
  EXPECT_EQ(verdict(1.09, 0.0, 0.1).verdict, ClaimVerdict::value);
  EXPECT_EQ(verdict(1.13, 0.0, 0.1).verdict, ClaimVerdict::not_reproduced);
  EXPECT_EQ(verdict(1.13, 0.01, 0.1).verdict, ClaimVerdict::value);
  EXPECT_EQ(verdict(1.09, 0.0, 0.01).cases[0].value_remark, "too uncertain to tell");
}

TEST(Verdict, AllCasesMustHold) {
  std::vector<Measurement> rows;
  plant(rows, "ssdo", "rmse", around(2.0, 0.01, 1));
  plant(rows, "s3ho", "rmse", around(1.0, 0.01, 2));
  plant(rows, "ssbn", "rmse", around(3.0, 0.01, 3));
  const auto claim = [&](const std::vector<std::string>& others) {
    Claim made = statement_claim("rmse(ssdo, 32) > rmse(s3ho, 32)");
    made.cases.clear();
    for (const std::string& other : others) {
      made.cases.push_back(
          statement_claim(fmt::format("rmse(ssdo, 32) > rmse({}, 32)", other)).cases.front());
    }
    return judge(made, rows);
  };
  EXPECT_EQ(claim({"s3ho"}).verdict, ClaimVerdict::ordering);
  const JudgedClaim mixed = claim({"s3ho", "ssbn"});
  EXPECT_EQ(mixed.verdict, ClaimVerdict::not_reproduced);
  EXPECT_EQ(mixed.holding(), 1U);
  // ssao is not measured: what is left holds, and is not enough.
  const JudgedClaim missing = claim({"s3ho", "ssao"});
  EXPECT_EQ(missing.verdict, ClaimVerdict::untestable);
  EXPECT_EQ(missing.holding(), 1U);
  EXPECT_EQ(claim({"ssao", "ssbn"}).verdict, ClaimVerdict::not_reproduced);
}

TEST(Verdict, HardwareClaimsSayNothingOfASoftwareRasteriser) {
  std::vector<Measurement> rows;
  plant_time(rows, "ssao", 10.0, 1.0, 1.0, 1.0);
  Claim claim = value_claim("time(ssao, 32)", 10.0);
  EXPECT_EQ(judge(claim, rows).verdict, ClaimVerdict::value);
  claim.hardware = true;
  const JudgedClaim judged = judge(claim, rows);
  EXPECT_EQ(judged.verdict, ClaimVerdict::untestable);
  EXPECT_NE(judged.reason.find("llvmpipe (software)"), std::string::npos);
  for (Measurement& row : rows) row.device = "a GPU";
  EXPECT_EQ(judge(claim, rows).verdict, ClaimVerdict::value);
}

TEST(Verdict, SaysThatTheSeedsAreTooFew) {
  std::vector<Measurement> rows;
  plant(rows, "ssdo", "rmse", {2.0, 2.1, 1.9});
  plant(rows, "s3ho", "rmse", {1.0, 1.01, 0.99});
  ClaimFile file = file_with({statement_claim("rmse(ssdo, 32) > rmse(s3ho, 32)")});
  const std::vector<MeasuredFolder> folders = {{"planted", rows}};
  ClaimEstimator estimator(folders);
  const auto tables = claim_tables(file, judge_claims(file, estimator));
  const auto& outcome = std::get<std::string>(tables[1].rows[0][5]);
  EXPECT_EQ(outcome, "unresolved: 3 paired seeds give no p-value below 0.11");
}

// --- the record
// -----------------------------------------------------------------------------------

TEST(Record, KnowsWhatWasLost) {
  std::vector<Measurement> good;
  plant(good, "ssdo", "rmse", around(2.0, 0.1, 1));
  plant(good, "s3ho", "rmse", around(1.0, 0.1, 2));
  const ClaimFile file = file_with({statement_claim("rmse(ssdo, 32) > rmse(s3ho, 32)")});
  const auto judge_rows = [&](std::vector<Measurement> rows) {
    const std::vector<MeasuredFolder> folders = {{"planted", std::move(rows)}};
    ClaimEstimator estimator(folders);
    return judge_claims(file, estimator);
  };
  const ClaimRecord record = accept({}, judge_rows(good), "abc");
  EXPECT_TRUE(compare(record, judge_rows(good)).lost.empty());
  std::vector<Measurement> bad;
  plant(bad, "ssdo", "rmse", around(1.0, 0.1, 1));
  plant(bad, "s3ho", "rmse", around(1.0, 0.1, 2));
  EXPECT_EQ(compare(record, judge_rows(bad)).lost.size(), 1U);
  // Nothing measured: not lost, but said; and accepting keeps what was known.
  const RecordComparison nothing = compare(record, judge_rows({}));
  EXPECT_TRUE(nothing.lost.empty());
  EXPECT_EQ(nothing.untested, 1U);
  EXPECT_EQ(accept(record, judge_rows({}), "abc").claims.at("planted").verdict,
            ClaimVerdict::ordering);
  // A claim that is gone is lost; one with another statement is not compared.
  ClaimRecord changed = record;
  changed.claims["gone"] = changed.claims["planted"];
  EXPECT_EQ(compare(changed, judge_rows(good)).lost.size(), 1U);
  changed = record;
  changed.claims["planted"].statement = "another";
  EXPECT_TRUE(compare(changed, judge_rows(bad)).lost.empty());
}

TEST(Record, IsReadBackAndRefusesOthersFiles) {
  const std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) / "claims_record.json";
  std::vector<Measurement> rows;
  plant(rows, "ssdo", "rmse", around(2.0, 0.1, 1));
  plant(rows, "s3ho", "rmse", around(1.0, 0.1, 2));
  const ClaimFile file = file_with({statement_claim("rmse(ssdo, 32) > rmse(s3ho, 32)")});
  const std::vector<MeasuredFolder> folders = {{"planted", rows}};
  ClaimEstimator estimator(folders);
  write_record(path, accept({}, judge_claims(file, estimator), "abc"));
  const ClaimRecord read = read_record(path);
  EXPECT_EQ(read.commit, "abc");
  EXPECT_EQ(read.claims.at("planted").verdict, ClaimVerdict::ordering);
  EXPECT_EQ(read.claims.at("planted").device, "llvmpipe (software)");
  write_text_atomically(path, R"({"format": 1, "commit": "abc", "claims": {"x": {"verdict": 3}}})");
  EXPECT_NE(message_of([&] { read_record(path); }).find("claims.x: key 'verdict'"),
            std::string::npos);
  write_text_atomically(path, "{}");
  EXPECT_NE(message_of([&] { read_record(path); }).find("key 'format': missing"),
            std::string::npos);
  EXPECT_TRUE(read_record(path.string() + ".none").claims.empty());
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace occlab
