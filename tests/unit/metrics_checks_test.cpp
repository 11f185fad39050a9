#include "harness/verify/metrics_checks.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace occlab {
namespace {

TEST(MetricsChecks, AllPass) {
  const Checks checks = verify_metrics();
  EXPECT_GT(checks.size(), 15u);
  for (const Check& check : checks) {
    EXPECT_TRUE(check.passes) << check.name << ", " << check.quantity << ": " << check.measured
                              << " instead of " << check.expected << ' ' << check.detail;
    EXPECT_EQ(check.subject, "metrics");
    EXPECT_FALSE(check.rule.empty()) << check.name;
  }
}

TEST(MetricsChecks, EmbedTheGoldenValues) {
  std::ifstream file(OCCLAB_TEST_DIR "/golden/metrics.json");
  const nlohmann::json noise = nlohmann::json::parse(file).at("cases").at(0);
  ASSERT_EQ(noise.at("name"), "noise");
  int found = 0;
  for (const Check& check : verify_metrics()) {
    if (check.name.find("noise") == std::string::npos) continue;
    EXPECT_EQ(check.expected, noise.at("expected").at(check.quantity).get<double>());
    ++found;
  }
  EXPECT_EQ(found, 8);
}

}  // namespace
}  // namespace occlab
