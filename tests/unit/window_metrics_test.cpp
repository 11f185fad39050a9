#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "harness/metrics/colour.h"
#include "harness/metrics/metrics.h"
#include "tests/unit/metric_images.h"

namespace occlab {
namespace {

using namespace metrics_test;

TEST(Ssim, OfConstantImages) {
  const Image reference(20, 15, 3, 1.0f);
  const Image test(20, 15, 3, 0.5f);
  const double b = 0.735356983;
  EXPECT_NEAR(value_of({reference, test, all_of(test)}, "ssim"),
              (2 * b + 1e-4) / (1 + b * b + 1e-4), 1e-6);
  EXPECT_EQ(by_name({reference, test, all_of(test)}).at("ssim").pixels, 10u * 5u);
}

TEST(Ssim, NeedsAWholeWindow) {
  const Image image = noise_image(20, 10, 1);
  EXPECT_FALSE(by_name({image, image, all_of(image)}).at("ssim").value.has_value());
  const Image square = noise_image(11, 11, 1);
  EXPECT_EQ(by_name({square, square, all_of(square)}).at("ssim").pixels, 1u);
  Image mask = all_of(square);
  mask.at(10, 0) = 0;
  const MetricValue holed = by_name({square, square, mask}).at("ssim");
  EXPECT_FALSE(holed.value.has_value());
  EXPECT_FALSE(holed.reason.empty());
}

double exposed_luma(const Image& image, int x, int y, double exposure) {
  Rgb rgb{};
  for (int c = 0; c < 3; ++c) {
    rgb[std::size_t(c)] = srgb_encode(std::min(1.0, double(image.at(x, y, c)) * exposure));
  }
  return luminance(rgb);
}

TEST(Ssim, AgreesWithTheDefinitionWrittenOut) {
  const int size = 40;
  Image reference = noise_image(size, size, 5);
  const Image test = noise_image(size, size, 6);
  Image mask = all_of(test);
  for (int x = 0; x < size; ++x) mask.at(x, x < 20 ? 0 : 39) = 0;
  mask.at(33, 12) = 0;
  // More than 1% at one luminance that nothing exceeds pins the exposure down.
  for (int x = 0; x < size; ++x) {
    for (int c = 0; c < 3; ++c) reference.at(x, 20, c) = 4.0f;
  }
  const double exposure = 1 / 4.0;
  double sum = 0;
  int windows = 0;
  for (int cy = 5; cy < size - 5; ++cy) {
    for (int cx = 5; cx < size - 5; ++cx) {
      double weight = 0, mx = 0, mr = 0, xx = 0, rr = 0, xr = 0;
      bool whole = true;
      for (int y = cy - 5; y <= cy + 5; ++y) {
        for (int x = cx - 5; x <= cx + 5; ++x) {
          whole = whole && mask.at(x, y) > 0.5f;
          const double w =
              std::exp(-((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (2.0 * 1.5 * 1.5));
          const double a = exposed_luma(test, x, y, exposure);
          const double b = exposed_luma(reference, x, y, exposure);
          weight += w, mx += w * a, mr += w * b, xx += w * a * a, rr += w * b * b, xr += w * a * b;
        }
      }
      if (!whole) continue;
      mx /= weight, mr /= weight;
      const double vx = xx / weight - mx * mx;
      const double vr = rr / weight - mr * mr;
      const double vxr = xr / weight - mx * mr;
      sum +=
          (2 * mx * mr + 1e-4) * (2 * vxr + 9e-4) / ((mx * mx + mr * mr + 1e-4) * (vx + vr + 9e-4));
      ++windows;
    }
  }
  const MetricValue ssim = by_name({reference, test, mask}).at("ssim");
  EXPECT_EQ(ssim.pixels, std::size_t(windows));
  EXPECT_LT(windows, 30 * 30);
  EXPECT_NEAR(ssim.value.value(), sum / windows, 1e-6);
}

TEST(HighFrequencyResidual, ConstantErrorHasNone) {
  const Image reference = noise_image(30, 26, 7);
  Image test = reference;
  for (float& v : test.values()) v += 0.25f;
  const Image mask = ragged_mask(30, 26);
  EXPECT_NEAR(value_of({reference, test, mask}, "high_frequency_residual_2"), 0.0, 1e-6);
  EXPECT_NEAR(value_of({reference, test, mask}, "high_frequency_residual_4"), 0.0, 1e-6);
}

TEST(HighFrequencyResidual, CheckerboardIsKept) {
  // The Gaussian averages the alternating error away but for the windows cut off at the border.
  const Image reference(64, 64, 3, 1.0f);
  Image test = reference;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      for (int c = 0; c < 3; ++c) test.at(x, y, c) += (x + y) % 2 == 0 ? 0.5f : -0.5f;
    }
  }
  const ComparisonInput input{reference, test, all_of(test)};
  EXPECT_NEAR(value_of(input, "high_frequency_residual_2"), 0.5, 0.002);
  EXPECT_NEAR(value_of(input, "rmse"), 0.5, 1e-6);
}

double residual_written_out(const Image& reference, const Image& test, const Image& mask,
                            double sigma) {
  double luminance_sum = 0, count = 0;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (!(mask.at(x, y) > 0.5f)) continue;
      luminance_sum +=
          luminance({reference.at(x, y, 0), reference.at(x, y, 1), reference.at(x, y, 2)});
      ++count;
    }
  }
  const int radius = int(4 * sigma);
  double squares = 0;
  for (int cy = 0; cy < mask.height(); ++cy) {
    for (int cx = 0; cx < mask.width(); ++cx) {
      if (!(mask.at(cx, cy) > 0.5f)) continue;
      for (int c = 0; c < 3; ++c) {
        double weight = 0, low = 0;
        for (int y = std::max(0, cy - radius); y <= std::min(mask.height() - 1, cy + radius); ++y) {
          for (int x = std::max(0, cx - radius); x <= std::min(mask.width() - 1, cx + radius);
               ++x) {
            if (!(mask.at(x, y) > 0.5f)) continue;
            const double w =
                std::exp(-((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (2 * sigma * sigma));
            weight += w;
            low += w * (double(test.at(x, y, c)) - reference.at(x, y, c));
          }
        }
        const double high = double(test.at(cx, cy, c)) - reference.at(cx, cy, c) - low / weight;
        squares += high * high;
      }
    }
  }
  return std::sqrt(squares / (3 * count)) / (luminance_sum / count);
}

TEST(HighFrequencyResidual, AgreesWithTheDefinitionWrittenOut) {
  const Image reference = noise_image(37, 29, 8);
  const Image test = noise_image(37, 29, 9);
  const Image mask = ragged_mask(37, 29);
  for (const int sigma : {2, 4}) {
    EXPECT_NEAR(
        value_of({reference, test, mask}, "high_frequency_residual_" + std::to_string(sigma)),
        residual_written_out(reference, test, mask, sigma), 1e-6);
  }
}

}  // namespace
}  // namespace occlab
