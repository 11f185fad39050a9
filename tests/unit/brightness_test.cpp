// A picture's own brightness: exact means, the mask, and what is not finite.

#include "harness/metrics/brightness.h"

#include <gtest/gtest.h>

#include <limits>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

Image two_pixels() {
  Image image(3, 1, 3);
  const float values[] = {1.0f, 2.0f, 4.0f, 3.0f, 0.0f, 1.0f, 100.0f, 100.0f, 100.0f};
  std::copy(std::begin(values), std::end(values), image.values().begin());
  return image;
}

Image mask_of(float last) {
  Image mask(3, 1, 1);
  mask.values()[0] = mask.values()[1] = 1.0f;
  mask.values()[2] = last;
  return mask;
}

double value_of(const std::vector<MetricValue>& all, const std::string& name) {
  for (const MetricValue& metric : all) {
    if (metric.name == name) return metric.value.value();
  }
  throw InputError("no " + name);
}

TEST(Brightness, MeansOverTheMask) {
  const auto all = measure_brightness(two_pixels(), mask_of(0.5f));
  ASSERT_EQ(all.size(), brightness_metrics().size());
  EXPECT_DOUBLE_EQ(value_of(all, "mean_red"), 2.0);
  EXPECT_DOUBLE_EQ(value_of(all, "mean_green"), 1.0);
  EXPECT_DOUBLE_EQ(value_of(all, "mean_blue"), 2.5);
  EXPECT_DOUBLE_EQ(value_of(all, "mean_luminance"), 0.2126 * 2.0 + 0.7152 * 1.0 + 0.0722 * 2.5);
  for (const MetricValue& metric : all) {
    EXPECT_EQ(metric.pixels, 2u);
    EXPECT_TRUE(is_brightness_metric(metric.name));
  }
  EXPECT_FALSE(is_brightness_metric("rmse"));
}

TEST(Brightness, PixelsThatAreNotFiniteAreAReason) {
  Image image = two_pixels();
  image.values()[4] = std::numeric_limits<float>::quiet_NaN();
  for (const MetricValue& metric : measure_brightness(image, mask_of(0.0f))) {
    EXPECT_FALSE(metric.value);
    EXPECT_EQ(metric.reason, "1 pixels are not finite");
  }
}

TEST(Brightness, BadInput) {
  Image empty(3, 1, 1);
  EXPECT_THROW(measure_brightness(two_pixels(), empty), InputError);
  EXPECT_THROW(measure_brightness(two_pixels(), Image(2, 1, 1)), InputError);
  EXPECT_THROW(measure_brightness(Image(3, 1, 1), mask_of(1.0f)), InputError);
}

}  // namespace
}  // namespace occlab
