// The metrics against tests/golden/metrics.json, values that tests/golden/make_golden.py computed
// from the papers.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "harness/metrics/metrics.h"
#include "tests/unit/metric_images.h"

namespace occlab {
namespace {

using nlohmann::json;
using namespace metrics_test;

/// Images are compared in float, whose rounding the pixels' means hardly show.
constexpr double bound = 2e-6;
/// FLIP with a matrix of more digits, as the authors' program has it.
constexpr double bound_of_matrix = 2e-5;

struct GoldenCase {
  std::string name;
  Image reference, test, mask;
  json expected;
};

Image image_of(const json& values, int width, int height, int channels, double divisor) {
  Image image(width, height, channels);
  EXPECT_EQ(values.size(), image.values().size());
  for (std::size_t i = 0; i < image.values().size(); ++i) {
    image.values()[i] = static_cast<float>(values.at(i).get<int>() / divisor);
  }
  return image;
}

std::vector<GoldenCase> golden_cases() {
  std::ifstream file(OCCLAB_TEST_DIR "/golden/metrics.json");
  const json golden = json::parse(file);
  const double divisor = golden.at("divisor");
  std::vector<GoldenCase> cases;
  for (const json& entry : golden.at("cases")) {
    const int width = entry.at("width"), height = entry.at("height");
    cases.push_back({entry.at("name"), image_of(entry.at("reference"), width, height, 3, divisor),
                     image_of(entry.at("test"), width, height, 3, divisor),
                     image_of(entry.at("mask"), width, height, 1, 1.0), entry.at("expected")});
  }
  return cases;
}

class Golden : public testing::TestWithParam<GoldenCase> {};

TEST_P(Golden, MetricsAreThoseOfThePapers) {
  const GoldenCase& golden = GetParam();
  const auto values = by_name({golden.reference, golden.test, golden.mask});
  for (const char* name :
       {"rmse", "relmse", "smape", "psnr", "ssim", "flip_ldr", "flip_hdr", "ciede2000"}) {
    const MetricValue& value = values.at(name);
    const json& expected = golden.expected.at(name);
    EXPECT_EQ(value.value.has_value(), !expected.is_null()) << name << ": " << value.reason;
    if (!value.value || expected.is_null()) continue;
    const double number = expected.get<double>();
    EXPECT_NEAR(*value.value, number, bound * std::max(1.0, number)) << name;
  }
}

TEST_P(Golden, FlipHardlyDependsOnTheDigitsOfTheMatrix) {
  const GoldenCase& golden = GetParam();
  const auto values = by_name({golden.reference, golden.test, golden.mask});
  for (const std::string name : {"flip_ldr", "flip_hdr"}) {
    EXPECT_NEAR(values.at(name).value.value(), golden.expected.at(name + "_fine_matrix"),
                bound_of_matrix)
        << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Images, Golden, testing::ValuesIn(golden_cases()),
                         [](const auto& tested) { return tested.param.name; });

TEST(GoldenFile, HoldsWhatTheMetricsAreFor) {
  const std::vector<GoldenCase> cases = golden_cases();
  ASSERT_EQ(cases.size(), 7u);
  int with_ssim = 0;
  for (const GoldenCase& golden : cases) with_ssim += golden.expected.at("ssim").is_null() ? 0 : 1;
  EXPECT_EQ(with_ssim, 5);
}

}  // namespace
}  // namespace occlab
