#include <gtest/gtest.h>

#include <cmath>

#include "harness/metrics/metrics.h"
#include "tests/unit/metric_images.h"

namespace occlab {
namespace {

using namespace metrics_test;

// Five pixels: in shadow (red against green, equal up to brightness), open, too dark in the test
// image, and too dark in the reference.
class ShadowMetrics : public testing::Test {
 protected:
  Image reference =
      row_of({{1, 0, 0}, {0.2f, 0.1f, 0.4f}, {1, 0, 0}, {1, 1, 1}, {0.001f, 0.001f, 0.001f}});
  Image test = row_of({{0, 1, 0}, {0.1f, 0.05f, 0.2f}, {0, 1, 0}, {0.001f, 0, 0}, {1, 1, 1}});
  Image mask = all_of(test);
  Image occlusion = scalars({0.2f, 0.89f, 0.91f, 0.5f, 0.5f});
  ComparisonInput input{reference, test, mask, &occlusion};
};

TEST_F(ShadowMetrics, RgbAngle) {
  EXPECT_NEAR(value_of(input, "rgb_angle_shadow"), 90.0 / 2, 1e-5);
  EXPECT_EQ(by_name(input).at("rgb_angle_shadow").pixels, 2u);
}

TEST_F(ShadowMetrics, ExcludedShare) {
  EXPECT_NEAR(value_of(input, "shadow_excluded"), 2.0 / 4, 1e-12);
}

TEST_F(ShadowMetrics, Chromaticity) {
  // Red (0.4507, 0.5229), green (0.1250, 0.5625); nothing between the other two.
  EXPECT_NEAR(value_of(input, "delta_uv_shadow"), std::hypot(0.4507 - 0.1250, 0.5229 - 0.5625) / 2,
              1e-4);
}

TEST_F(ShadowMetrics, Hue) {
  // Hues of the primaries: atan2(67.2032, 80.0925) = 40.0, atan2(83.1793, -86.1827) = 136.016.
  // The exposure scales X, Y and Z alike, and with them a* and b*. The other pair is one hue, up
  // to its darker half reaching the straight part of the Lab curve in neither image.
  EXPECT_NEAR(value_of(input, "hue_shadow"), (136.016 - 40.0) / 2, 0.05);
  EXPECT_EQ(by_name(input).at("hue_shadow").pixels, 2u);
}

TEST_F(ShadowMetrics, GreysHaveNoHue) {
  const Image grey_reference = greys({1, 1});
  const Image grey_test = greys({0.5f, 1});
  const Image dark = scalars({0.5f, 0.5f});
  const auto values = by_name({grey_reference, grey_test, all_of(grey_test), &dark});
  EXPECT_FALSE(values.at("hue_shadow").value.has_value());
  EXPECT_FALSE(values.at("hue_shadow").reason.empty());
  EXPECT_NEAR(values.at("rgb_angle_shadow").value.value(), 0.0, 1e-12);
}

TEST_F(ShadowMetrics, WithoutOcclusionNothingIsMeasured) {
  const auto values = by_name({reference, test, mask});
  for (const char* name :
       {"rgb_angle_shadow", "delta_uv_shadow", "hue_shadow", "shadow_excluded"}) {
    EXPECT_FALSE(values.at(name).value.has_value()) << name;
    EXPECT_NE(values.at(name).reason.find("ambient occlusion"), std::string::npos) << name;
  }
  EXPECT_TRUE(values.at("rmse").value.has_value());
}

TEST_F(ShadowMetrics, WithoutShadowNothingIsMeasured) {
  const Image open = scalars({1, 1, 1, 1, 1});
  const auto values = by_name({reference, test, mask, &open});
  for (const char* name :
       {"rgb_angle_shadow", "delta_uv_shadow", "hue_shadow", "shadow_excluded"}) {
    EXPECT_FALSE(values.at(name).value.has_value()) << name;
    EXPECT_FALSE(values.at(name).reason.empty()) << name;
  }
}

TEST_F(ShadowMetrics, NegativeLightHasNoChromaticity) {
  test.at(0, 0, 2) = -0.1f;
  const auto values = by_name(input);
  EXPECT_FALSE(values.at("delta_uv_shadow").value.has_value());
  EXPECT_NE(values.at("delta_uv_shadow").reason.find("negative"), std::string::npos);
  EXPECT_TRUE(values.at("rgb_angle_shadow").value.has_value());
}

}  // namespace
}  // namespace occlab
