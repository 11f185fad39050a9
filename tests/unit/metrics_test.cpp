#include "harness/metrics/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "harness/metrics/colour.h"
#include "renderers/scene/error.h"
#include "tests/unit/metric_images.h"

namespace occlab {
namespace {

using namespace metrics_test;

TEST(Registry, EveryMetricSaysWhatItIs) {
  std::set<std::string> names;
  for (const MetricInfo& info : metrics()) {
    EXPECT_TRUE(names.insert(info.name).second) << info.name;
    EXPECT_FALSE(info.unit.empty()) << info.name;
    EXPECT_GT(info.definition.size(), 20u) << info.name;
  }
  const Image image = noise_image(20, 20, 1);
  const std::vector<MetricValue> values = measure({image, image, all_of(image)});
  ASSERT_EQ(values.size(), metrics().size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_EQ(values[i].name, metrics()[i].name);
    EXPECT_EQ(values[i].unit, metrics()[i].unit);
  }
}

// Two pixels in the mask: references 1 and 3 of mean luminance 2, so r = 0.5, 1.5 and x = 1, 1.5.
// What lies outside the mask must not matter, whatever it is.
class TwoGreys : public testing::Test {
 protected:
  Image reference = greys({1, 3, not_a_number});
  Image test = greys({2, 3, infinite});
  Image mask = scalars({1.0f, 0.6f, 0.5f});
};

TEST_F(TwoGreys, Rmse) {
  EXPECT_NEAR(value_of({reference, test, mask}, "rmse"), std::sqrt(0.25 / 2), 1e-7);
}

TEST_F(TwoGreys, RelativeMse) {
  EXPECT_NEAR(value_of({reference, test, mask}, "relmse"), 0.25 / (0.25 + 0.01) / 2, 1e-7);
}

TEST_F(TwoGreys, Smape) {
  EXPECT_NEAR(value_of({reference, test, mask}, "smape"), 0.5 / (0.5 + 1.0 + 0.01) / 2, 1e-7);
}

TEST_F(TwoGreys, CountsTheForeground) {
  for (const char* name : {"rmse", "relmse", "smape", "psnr", "ciede2000"}) {
    EXPECT_EQ(by_name({reference, test, mask}).at(name).pixels, 2u) << name;
  }
}

TEST_F(TwoGreys, ReferenceVarianceIsSubtracted) {
  const Image variance = greys({0.2f, 0.4f, -1.0f});  // 0.05 and 0.1 of squared mean luminance
  const ComparisonInput input{reference, test, mask, nullptr, &variance};
  EXPECT_NEAR(value_of(input, "rmse"), std::sqrt((0.25 - 0.05 - 0.1) / 2), 1e-7);
  EXPECT_NEAR(value_of(input, "relmse"), ((0.25 - 0.05) / 0.26 - 0.1 / 2.26) / 2, 1e-7);
}

TEST_F(TwoGreys, DifferenceWithinTheReferencesNoiseIsNotMeasured) {
  const Image variance = greys({2, 2, 2});
  const auto values = by_name({reference, test, mask, nullptr, &variance});
  for (const char* name : {"rmse", "relmse"}) {
    EXPECT_FALSE(values.at(name).value.has_value()) << name;
    EXPECT_NE(values.at(name).reason.find("reference's own noise"), std::string::npos) << name;
  }
  EXPECT_TRUE(values.at("smape").value.has_value());
}

TEST(PixelMetrics, ErrorsAreAveragedOverChannels) {
  // Mean luminance 1; the green channel alone is off by 0.6.
  const Image reference = greys({1});
  const Image test = row_of({{1, 1.6f, 1}});
  const Image mask = all_of(test);
  EXPECT_NEAR(value_of({reference, test, mask}, "rmse"), 0.6 / std::sqrt(3.0), 1e-7);
  EXPECT_NEAR(value_of({reference, test, mask}, "relmse"), 0.36 / 1.01 / 3, 1e-7);
  EXPECT_NEAR(value_of({reference, test, mask}, "smape"), 0.6 / 2.61 / 3, 1e-7);
}

TEST(PixelMetrics, NormalisationIsByLuminance) {
  const Image reference = row_of({{1, 0, 0}});
  const Image test = row_of({{2, 0, 0}});
  EXPECT_NEAR(value_of({reference, test, all_of(test)}, "rmse"), 1 / 0.2126 / std::sqrt(3.0), 1e-6);
}

TEST(PixelMetrics, UnitOfRadianceDoesNotMatter) {
  const Image reference = noise_image(24, 20, 2);
  const Image test = noise_image(24, 20, 3);
  const Image occlusion(24, 20, 1, 0.4f);
  Image far_reference = reference;
  Image far_test = test;
  for (float& v : far_reference.values()) v *= 4096.0f;
  for (float& v : far_test.values()) v *= 4096.0f;
  const Image mask = all_of(reference);
  const auto near = measure({reference, test, mask, &occlusion});
  const auto far = measure({far_reference, far_test, mask, &occlusion});
  for (std::size_t i = 0; i < near.size(); ++i) {
    EXPECT_NEAR(near[i].value.value(), far[i].value.value(), 1e-9) << near[i].name;
  }
}

TEST(Psnr, OfAConstantError) {
  // The exposure takes the reference to 1; sRGB of 0.5 is 0.735357.
  const Image reference = greys({8, 8});
  const Image test = greys({4, 8});
  EXPECT_NEAR(value_of({reference, test, all_of(test)}, "psnr"),
              -10 * std::log10(std::pow(1 - 0.735356983, 2) / 2), 1e-5);
}

TEST(Psnr, ExposureIsThe99thPercentileOfTheReference) {
  Image reference(101, 1, 3);
  for (int x = 0; x <= 100; ++x) {
    for (int c = 0; c < 3; ++c) reference.at(x, 0, c) = float(x);
  }
  Image test = reference;
  // 99 becomes 1, 100 is clamped, and so is anything brighter in its place.
  for (int c = 0; c < 3; ++c) test.at(100, 0, c) = 500;
  EXPECT_EQ(value_of({reference, test, all_of(test)}, "psnr"),
            std::numeric_limits<double>::infinity());
  for (int c = 0; c < 3; ++c) test.at(99, 0, c) = 49.5f;
  EXPECT_NEAR(value_of({reference, test, all_of(test)}, "psnr"),
              -10 * std::log10(std::pow(1 - 0.735356983, 2) / 101), 1e-4);
}

TEST(Ciede2000Metric, IsTheMeanOverTheForeground) {
  const Image reference = greys({1, 1});
  const Image test = row_of({{1, 1, 1}, {0.5f, 0.25f, 2.0f}});  // the blue is clamped to 1
  const double expected = ciede2000({100, 0, 0}, xyz_to_lab(rgb_to_xyz({0.5, 0.25, 1.0}))) / 2;
  EXPECT_NEAR(value_of({reference, test, all_of(test)}, "ciede2000"), expected, 1e-4);
}

TEST(EqualImages, AreWithoutError) {
  const Image image = noise_image(32, 24, 10);
  const Image occlusion(32, 24, 1, 0.5f);
  const auto values = by_name({image, image, all_of(image), &occlusion});
  for (const MetricInfo& info : metrics()) {
    const double perfect = info.name == "psnr"   ? std::numeric_limits<double>::infinity()
                           : info.name == "ssim" ? 1.0
                                                 : 0.0;
    EXPECT_EQ(values.at(info.name).value.value(), perfect) << info.name;
    EXPECT_GT(values.at(info.name).pixels, 0u) << info.name;
  }
}

TEST(BlackPixels, AreFinite) {
  const Image reference = greys({0, 0, 1});
  const Image test = greys({0, 1, 0});
  // r = 0, 0, 3 and x = 0, 3, 0 in units of the mean luminance.
  EXPECT_NEAR(value_of({reference, test, all_of(test)}, "relmse"), (9 / 0.01 + 9 / 9.01) / 3, 1e-4);
  EXPECT_NEAR(value_of({reference, test, all_of(test)}, "smape"), 2 * 3 / 3.01 / 3, 1e-6);
  for (const auto& [name, value] : by_name({reference, test, all_of(test)})) {
    EXPECT_TRUE(!value.value || std::isfinite(*value.value)) << name;
  }
}

TEST(BlackReference, IsNotMeasured) {
  const Image black = greys({0, 0});
  const Image test = greys({0, 1});
  for (const MetricValue& value : measure({black, test, all_of(test)})) {
    EXPECT_FALSE(value.value.has_value()) << value.name;
    EXPECT_NE(value.reason.find("mean luminance"), std::string::npos) << value.name;
  }
  EXPECT_THROW(error_map({black, test, all_of(test)}, ErrorMap::rms), InputError);
}

TEST(AlmostBlackReference, HasNoExposure) {
  Image reference(200, 1, 3);
  for (int c = 0; c < 3; ++c) reference.at(7, 0, c) = 1;
  const auto values = by_name({reference, reference, all_of(reference)});
  for (const char* name : {"psnr", "ssim", "ciede2000"}) {
    EXPECT_FALSE(values.at(name).value.has_value()) << name;
    EXPECT_NE(values.at(name).reason.find("99th percentile"), std::string::npos) << name;
  }
  EXPECT_EQ(values.at("rmse").value.value(), 0.0);
}

TEST(BadTestPixels, AreCountedAndFailEveryMetric) {
  const Image reference = greys({1, 2, 3, 4});
  Image test = reference;
  test.at(0, 0, 1) = not_a_number;
  test.at(2, 0, 0) = infinite;
  test.at(2, 0, 2) = -infinite;
  for (const MetricValue& value : measure({reference, test, all_of(test)})) {
    EXPECT_FALSE(value.value.has_value()) << value.name;
    EXPECT_EQ(value.reason, "2 non-finite pixels in the test image") << value.name;
  }
}

TEST(BadTestPixels, HugeValuesDoNotBecomeNumbers) {
  const Image reference = greys({1e-30f, 1e-30f});
  const Image test = greys({3e38f, 1e-30f});
  const MetricValue rmse = by_name({reference, test, all_of(test)}).at("rmse");
  EXPECT_FALSE(rmse.value.has_value());
  EXPECT_FALSE(rmse.reason.empty());
}

std::string message_of(const ComparisonInput& input) {
  try {
    measure(input);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(BadInput, IsRefusedByName) {
  const Image reference = greys({1, 2});
  const Image three = greys({1, 2, 3});
  const Image scalar = scalars({1, 1});
  const Image zero = scalars({0, 0.5f});
  const Image nan_mask = scalars({1, not_a_number});
  const Image nan_reference = greys({1, not_a_number});
  const Image nan_scalar = scalars({0.5f, not_a_number});
  const Image negative = greys({0.1f, -0.1f});
  const auto holds = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_PRED2(holds, message_of({reference, three, scalar}), "test image: 3 x 1");
  EXPECT_PRED2(holds, message_of({reference, scalar, scalar}), "test image: 1 channels");
  EXPECT_PRED2(holds, message_of({scalar, reference, scalar}), "reference image: 1 channels");
  EXPECT_PRED2(holds, message_of({reference, reference, reference}), "mask image: 3 channels");
  EXPECT_PRED2(holds, message_of({reference, reference, zero}), "none of its 2 x 1 pixels");
  EXPECT_PRED2(holds, message_of({reference, reference, nan_mask}), "mask image: value 1");
  EXPECT_PRED2(holds, message_of({nan_reference, reference, scalar}),
               "reference image: pixel (1, 0)");
  EXPECT_PRED2(holds, message_of({reference, reference, scalar, &nan_scalar}),
               "reference occlusion image: pixel (1, 0)");
  EXPECT_PRED2(holds, message_of({reference, reference, scalar, &reference}),
               "reference occlusion image: 3 channels");
  EXPECT_PRED2(holds, message_of({reference, reference, scalar, nullptr, &negative}),
               "reference variance image: pixel (1, 0)");
  EXPECT_PRED2(holds, message_of({reference, reference, scalar, nullptr, &nan_reference}),
               "reference variance image: pixel (1, 0)");
  EXPECT_PRED2(holds, message_of({reference, reference, scalar, nullptr, &three}),
               "reference variance image: 3 x 1");
  EXPECT_PRED2(holds, message_of({Image(0, 0, 3), Image(0, 0, 3), Image(0, 0, 1)}),
               "none of its 0 x 0 pixels");
}

TEST(Threads, DoNotChangeTheResult) {
  const Image reference = noise_image(200, 150, 11);
  const Image test = noise_image(200, 150, 12);
  const Image mask = ragged_mask(200, 150);
  const auto first = measure({reference, test, mask});
  for (int repetition = 0; repetition < 5; ++repetition) {
    const auto again = measure({reference, test, mask});
    for (std::size_t i = 0; i < first.size(); ++i) {
      EXPECT_EQ(first[i].value, again[i].value) << first[i].name;
    }
  }
}

TEST(ErrorMaps, ArePerPixelAndRelative) {
  const Image reference = greys({1, 3, 2, 9});
  Image test = row_of({{1, 2, 1}, {1, 1, 1}, {2, infinite, 2}, {0, 0, 0}});
  const Image mask = scalars({1, 1, 1, 0});  // mean luminance 2
  const Image luminances = error_map({reference, test, mask}, ErrorMap::signed_luminance);
  EXPECT_EQ(luminances.channels(), 1);
  EXPECT_NEAR(luminances.at(0, 0), 0.7152 / 2, 1e-7);
  EXPECT_NEAR(luminances.at(1, 0), -1.0, 1e-7);
  EXPECT_TRUE(std::isnan(luminances.at(2, 0)));
  EXPECT_EQ(luminances.at(3, 0), 0.0f);
  const Image rms = error_map({reference, test, mask}, ErrorMap::rms);
  EXPECT_NEAR(rms.at(0, 0), std::sqrt(1.0 / 3) / 2, 1e-7);
  EXPECT_NEAR(rms.at(1, 0), 1.0, 1e-7);
  EXPECT_TRUE(std::isnan(rms.at(2, 0)));
  EXPECT_EQ(rms.at(3, 0), 0.0f);
}

TEST(ErrorMaps, RmsMapHoldsTheRmse) {
  const Image reference = noise_image(32, 24, 13);
  const Image test = noise_image(32, 24, 14);
  const Image mask = all_of(test);
  const Image map = error_map({reference, test, mask}, ErrorMap::rms);
  double squares = 0;
  for (const float v : map.values()) squares += double(v) * v;
  EXPECT_NEAR(std::sqrt(squares / double(map.pixel_count())),
              value_of({reference, test, mask}, "rmse"), 1e-6);
}

}  // namespace
}  // namespace occlab
