#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "../unit/claim_measurements.h"

namespace occlab {
namespace {

// How often false claims are called reproduced. Each test's own false-alarm rate is below 1e-6:
// its bound is 5 standard errors of a simulated rate above the nominal one, and all is seeded.

constexpr int runs = 400;
constexpr double nominal = 0.05;
const double most = nominal + 5.0 * std::sqrt(nominal * (1.0 - nominal) / runs);

Values normal_values(std::mt19937_64& engine, double centre, double spread) {
  std::normal_distribution<double> normal(centre, spread);
  Values values(8);
  for (double& value : values) value = normal(engine);
  return values;
}

/// How often any of the claims of a file is called reproduced.
template <typename Plant>
double rate_of_any(const std::vector<std::string>& statements, Plant plant_rows) {
  std::vector<Claim> claims;
  for (const std::string& statement : statements) claims.push_back(statement_claim(statement));
  const ClaimFile file = file_with(claims);
  std::mt19937_64 engine(5);
  int reproduced = 0;
  for (int run = 0; run < runs; ++run) {
    std::vector<MeasuredFolder> folders = {{"planted", {}}};
    plant_rows(engine, folders.front().rows);
    ClaimEstimator estimator(folders);
    const JudgedClaims judged = judge_claims(file, estimator);
    reproduced += std::ranges::any_of(
        judged.all, [](const JudgedClaim& claim) { return is_reproduced(claim.verdict); });
  }
  return double(reproduced) / runs;
}

TEST(ClaimErrors, FalseOrderings) {
  // Four methods that do not differ, every pair claimed both ways: 12 false claims.
  const std::vector<std::string> methods = {"ssao", "s3ho", "ssdo", "ssbn"};
  std::vector<std::string> statements;
  for (const std::string& a : methods) {
    for (const std::string& b : methods) {
      if (a != b) statements.push_back(fmt::format("rmse({}, 32) > rmse({}, 32)", a, b));
    }
  }
  const double rate = rate_of_any(statements, [&](auto& engine, auto& rows) {
    for (const std::string& method : methods) {
      plant(rows, method, "rmse", normal_values(engine, 1.0, 0.05));
    }
  });
  EXPECT_LE(rate, most);
}

TEST(ClaimErrors, FalseEquivalences) {
  // On the margin's edge, where the claim is just false.
  const double rate =
      rate_of_any({"rmse(ssdo, 32) ~ rmse(s3ho, 32) within 10%"}, [](auto& engine, auto& rows) {
        plant(rows, "ssdo", "rmse", normal_values(engine, 1.1, 0.01));
        plant(rows, "s3ho", "rmse", normal_values(engine, 1.0, 0.01));
      });
  EXPECT_LE(rate, most);
  EXPECT_GT(rate, 0.0);
}

TEST(ClaimErrors, FalseOrderingsOfNoise) {
  // Noises without a stored pair, whose logarithms are normal with known errors: the added standard
  // errors are too long for independent ones, and exact where both err together.
  constexpr double error = 0.05;
  const double half = student_quantile(0.975, 7.0);
  for (const bool together : {false, true}) {
    const double rate = rate_of_any(
        {"noise(ssdo, 32) > noise(s3ho, 32)", "noise(ssdo, 32) < noise(s3ho, 32)"},
        [&](auto& engine, auto& rows) {
          std::normal_distribution<double> normal;
          std::chi_squared_distribution<double> chi_squared(7.0);
          const double shared = normal(engine);
          const double estimated = error * std::sqrt(chi_squared(engine) / 7.0);
          const double first = together ? shared : normal(engine);
          const double second = together ? -shared : normal(engine);
          for (const auto& [method, deviation] :
               {std::pair("ssdo", first), std::pair("s3ho", second)}) {
            const double value = std::exp(error * deviation);
            plant_estimate(rows, method, "noise", value, value * std::exp(-half * estimated),
                           value * std::exp(half * estimated), {method});
          }
        });
    EXPECT_LE(rate, most) << together;
    if (!together) {
      EXPECT_LE(rate, nominal);
    }
  }
}

TEST(ClaimErrors, TimesFromQuartiles) {
  // Medians of 20 normal times of one mean, independent: ratios of different numbers of samples.
  const double rate =
      rate_of_any({"time(ssdo, 32) > time(ssdo, 16)", "time(ssdo, 32) < time(ssdo, 16)"},
                  [](auto& engine, auto& rows) {
                    for (const char* samples : {"32", "16"}) {
                      std::normal_distribution<double> normal(50.0, 2.0);
                      Values times(20);
                      for (double& time : times) time = normal(engine);
                      const Quartiles found = quartiles(times);
                      Measurement row = claim_row("ssdo", "time_ms.occlusion");
                      row.parameters = {{"samples", samples}};
                      row.value = found.median;
                      row.lower = found.lower;
                      row.upper = found.upper;
                      row.n = 20;
                      rows.push_back(row);
                    }
                  });
  EXPECT_LE(rate, most);
}

TEST(ClaimErrors, PublishedValuesThatAreTrue) {
  // Missed in at most 5%: the interval covers the true ratio of 1.5.
  const ClaimFile file = file_with({value_claim("rmse(ssdo, 32) / rmse(s3ho, 32)", 1.5)});
  std::mt19937_64 engine(7);
  int missed = 0;
  for (int run = 0; run < runs; ++run) {
    std::vector<MeasuredFolder> folders = {{"planted", {}}};
    plant(folders[0].rows, "ssdo", "rmse", normal_values(engine, 1.5, 0.03));
    plant(folders[0].rows, "s3ho", "rmse", normal_values(engine, 1.0, 0.02));
    ClaimEstimator estimator(folders);
    missed += judge_claims(file, estimator).all[0].verdict != ClaimVerdict::value;
  }
  EXPECT_LE(double(missed) / runs, most);
}

TEST(ClaimErrors, TrueClaimsAreFound) {
  // A ratio of 1.2 with errors of 5%: of 400 runs with 8 seeds more than 95% find it.
  const double rate =
      rate_of_any({"rmse(ssdo, 32) > rmse(s3ho, 32)"}, [](auto& engine, auto& rows) {
        plant(rows, "ssdo", "rmse", normal_values(engine, 1.2, 0.05));
        plant(rows, "s3ho", "rmse", normal_values(engine, 1.0, 0.05));
      });
  EXPECT_GE(rate, 0.95);
}

}  // namespace
}  // namespace occlab
