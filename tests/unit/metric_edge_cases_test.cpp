// What every metric makes of degenerate images: the exact number, or the exact reason why there is
// none.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <variant>

#include "harness/metrics/metrics.h"
#include "renderers/scene/error.h"
#include "tests/unit/metric_images.h"

namespace occlab {
namespace {

using namespace metrics_test;

using Expected = std::map<std::string, std::variant<double, std::string>>;

const std::string no_occlusion = "no ambient occlusion of the reference was given";
const std::string no_window = "no 11 x 11 window lies wholly in the foreground";

// All metrics, but for those in shadow, which have no ambient occlusion to go by.
void expect_all(const ComparisonInput& input, Expected expected, double bound = 5e-6) {
  for (const char* name :
       {"rgb_angle_shadow", "delta_uv_shadow", "hue_shadow", "shadow_excluded"}) {
    expected.emplace(name, no_occlusion);
  }
  ASSERT_EQ(expected.size(), metrics().size());
  for (const auto& [name, value] : by_name(input)) {
    if (const double* number = std::get_if<double>(&expected.at(name))) {
      ASSERT_TRUE(value.value.has_value()) << name << ": " << value.reason;
      // Infinity is not near infinity.
      if (*value.value != *number) {
        EXPECT_NEAR(*value.value, *number, bound) << name;
      }
      EXPECT_EQ(value.reason, "") << name;
    } else {
      EXPECT_FALSE(value.value.has_value()) << name;
      EXPECT_EQ(value.reason, std::get<std::string>(expected.at(name))) << name;
    }
  }
}

// Every metric the same reason.
void expect_unmeasured(const ComparisonInput& input, const std::string& reason) {
  const auto values = measure(input);
  EXPECT_EQ(values.size(), metrics().size());
  for (const MetricValue& value : values) {
    EXPECT_FALSE(value.value.has_value()) << value.name;
    EXPECT_EQ(value.reason, reason) << value.name;
    EXPECT_EQ(value.pixels, 0u) << value.name;
  }
}

void expect_refused(const ComparisonInput& input, const std::string& message) {
  try {
    measure(input);
    FAIL() << "accepted, but expected: " << message;
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()), message);
  }
}

Image grey(int width, int height, float value) { return {width, height, 3, value}; }

/// FLIP's c_max, the colour difference of green and blue: HyAB = 203.3118964 to the power of 0.7.
const double c_max = std::pow(203.3118964, 0.7);

/// FLIP of two greys without features, given their L*.
double flip_of_greys(double l_first, double l_second) {
  const double power = std::pow(std::abs(l_first - l_second), 0.7);
  const double knee = 0.4 * c_max;
  return power < knee ? 0.95 * power / knee : 0.95 + 0.05 * (power - knee) / (c_max - knee);
}

TEST(EdgeCases, BlackTestIsAllError) {
  // L* of black and white differ by 100 about a mean of 50, where CIEDE2000 weighs them by 1.
  // HDR-FLIP shows the reference at 0.85 of the display.
  const double flip = flip_of_greys(100.0, 0.0);
  const double flip_hdr = flip_of_greys(116.0 * std::cbrt(0.85) - 16.0, 0.0);
  const Image reference = grey(30, 20, 5.0f);
  const Image test = grey(30, 20, 0.0f);
  expect_all({reference, test, all_of(reference)}, {{"rmse", 1.0},
                                                    {"relmse", 1.0 / 1.01},
                                                    {"smape", 1.0 / 1.01},
                                                    {"psnr", 0.0},
                                                    {"ssim", 1e-4 / (1.0 + 1e-4)},
                                                    {"flip_ldr", flip},
                                                    {"flip_hdr", flip_hdr},
                                                    {"ciede2000", 100.0},
                                                    {"high_frequency_residual_2", 0.0},
                                                    {"high_frequency_residual_4", 0.0}});
}

TEST(EdgeCases, BlackReferenceIsNotMeasured) {
  const std::string reason =
      "the reference's mean luminance over the foreground is 0, and errors are relative to it";
  const Image black = grey(13, 12, 0.0f);
  const Image test = noise_image(13, 12, 1);
  expect_unmeasured({black, test, all_of(black)}, reason);
  expect_unmeasured({black, black, all_of(black)}, reason);
}

TEST(EdgeCases, EqualConstantImagesAreWithoutError) {
  const Image image = grey(12, 13, 0.25f);
  expect_all({image, image, all_of(image)},
             {{"rmse", 0.0},
              {"relmse", 0.0},
              {"smape", 0.0},
              {"psnr", infinite},
              {"ssim", 1.0},
              {"flip_ldr", 0.0},
              {"flip_hdr", 0.0},
              {"ciede2000", 0.0},
              {"high_frequency_residual_2", 0.0},
              {"high_frequency_residual_4", 0.0}},
             0.0);
}

TEST(EdgeCases, OnePixelIsMeasuredButForItsWindows) {
  const Image image = grey(1, 1, 3.0f);
  expect_all({image, image, all_of(image)},
             {{"rmse", 0.0},
              {"relmse", 0.0},
              {"smape", 0.0},
              {"psnr", infinite},
              {"ssim", no_window},
              {"flip_ldr", 0.0},
              {"flip_hdr", 0.0},
              {"ciede2000", 0.0},
              {"high_frequency_residual_2", 0.0},
              {"high_frequency_residual_4", 0.0}},
             0.0);
}

TEST(EdgeCases, OneMaskedPixelIsMeasuredWithinItsGreySurroundings) {
  Image mask(9, 9, 1);
  mask.at(4, 4) = 1;
  const Image reference = noise_image(9, 9, 1);
  Image test = noise_image(9, 9, 2);
  for (int c = 0; c < 3; ++c) test.at(4, 4, c) = reference.at(4, 4, c);
  for (const MetricValue& value : measure({reference, test, mask})) {
    if (value.name == "ssim" || value.name.find("shadow") != std::string::npos) {
      EXPECT_FALSE(value.value.has_value()) << value.name;
    } else {
      EXPECT_EQ(value.value.value(), value.name == "psnr" ? double(infinite) : 0.0) << value.name;
      EXPECT_EQ(value.pixels, 1u) << value.name;
    }
  }
}

TEST(EdgeCases, SmallerThanTheFiltersAConstantErrorHasClosedForms) {
  // 3 x 2 pixels of reference 1 and test 1/2: sRGB 0.735357, L* 76.0693.
  const double encoded = 0.735356983052449;
  const double l = 76.0692610142;
  const double mean_l = 0.5 * (100.0 + l) - 50.0;
  const double s_l = 1.0 + 0.015 * mean_l * mean_l / std::sqrt(20.0 + mean_l * mean_l);
  const Image reference = grey(3, 2, 8.0f);
  const Image test = grey(3, 2, 4.0f);
  const auto aces = [](double x) {
    x *= 0.6;
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
  };
  // The positive root of (2.51 - 0.85 2.43) u^2 + (0.03 - 0.85 0.59) u - 0.85 0.14, u = 0.6 x.
  const double u = (0.4715 + std::sqrt(0.4715 * 0.4715 + 4 * 0.4445 * 0.119)) / (2 * 0.4445);
  const auto lightness = [](double y) { return 116.0 * std::cbrt(y) - 16.0; };
  expect_all({reference, test, all_of(reference)},
             {{"rmse", 0.5},
              {"relmse", 0.25 / 1.01},
              {"smape", 0.5 / 1.51},
              {"psnr", -20.0 * std::log10(1.0 - encoded)},
              {"ssim", no_window},
              {"flip_ldr", flip_of_greys(100.0, l)},
              {"flip_hdr", flip_of_greys(lightness(0.85), lightness(aces(0.5 * u / 0.6)))},
              {"ciede2000", (100.0 - l) / s_l},
              {"high_frequency_residual_2", 0.0},
              {"high_frequency_residual_4", 0.0}});
}

TEST(EdgeCases, TestPixelsThatAreNotFiniteAreCounted) {
  const Image reference = noise_image(12, 12, 1);
  for (const float bad : {not_a_number, infinite, -infinite}) {
    Image test = noise_image(12, 12, 2);
    test.at(3, 4, 1) = bad;
    expect_unmeasured({reference, test, all_of(test)}, "1 non-finite pixels in the test image");
    test.at(3, 4, 2) = bad;
    test.at(11, 11, 0) = bad;
    expect_unmeasured({reference, test, all_of(test)}, "2 non-finite pixels in the test image");
    Image mask = all_of(test);
    mask.at(3, 4) = 0;
    mask.at(11, 11) = 0;
    for (const MetricValue& value : measure({reference, test, mask})) {
      if (value.name.find("shadow") == std::string::npos && value.name != "ssim") {
        EXPECT_TRUE(std::isfinite(value.value.value())) << value.name;
      }
    }
  }
}

TEST(EdgeCases, ReferencePixelsThatAreNotFiniteAreAnError) {
  const Image test = noise_image(4, 3, 2);
  for (const auto& [bad, word] :
       {std::pair(not_a_number, "nan"), std::pair(infinite, "inf"), std::pair(-infinite, "-inf")}) {
    Image reference = noise_image(4, 3, 1);
    reference.at(2, 1, 2) = bad;
    expect_refused({reference, test, all_of(test)},
                   std::string("reference image: pixel (2, 1) holds ") + word +
                       "; accepted in the mask: finite values");
  }
}

TEST(EdgeCases, EmptyMaskIsAnError) {
  const Image image = noise_image(4, 3, 1);
  expect_refused({image, image, Image(4, 3, 1, 0.5f)},
                 "mask image: none of its 4 x 3 pixels exceeds 0.5; at least one foreground pixel "
                 "is needed");
}

TEST(EdgeCases, SizesThatDifferAreAnError) {
  const Image image = noise_image(4, 3, 1);
  const Image other = noise_image(3, 4, 1);
  expect_refused({image, other, all_of(image)},
                 "test image: 3 x 4 pixels; accepted: 4 x 3 as the others");
  expect_refused({image, image, all_of(other)},
                 "mask image: 3 x 4 pixels; accepted: 4 x 3 as the others");
  const Image occlusion(3, 4, 1);
  expect_refused({image, image, all_of(image), &occlusion},
                 "reference occlusion image: 3 x 4 pixels; accepted: 4 x 3 as the others");
  expect_refused({image, image, all_of(image), nullptr, &other},
                 "reference variance image: 3 x 4 pixels; accepted: 4 x 3 as the others");
}

}  // namespace
}  // namespace occlab
