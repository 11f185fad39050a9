// FLIP against closed forms and invariances; tests/unit/golden_test.cpp has the independent values.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "harness/metrics/colour.h"
#include "harness/metrics/fast_math.h"
#include "harness/metrics/flip_filters.h"
#include "harness/metrics/flip_map.h"
#include "harness/metrics/metrics.h"
#include "tests/unit/metric_images.h"

namespace occlab {
namespace {

using namespace metrics_test;

TEST(FastMath, ErrorsStayWithinTheStatedBounds) {
  double cbrt_error = 0, double_cbrt_error = 0, log2_error = 0, exp2_error = 0, power_error = 0;
  for (int step = 0; step < 27000; ++step) {
    const double exponent = 0.00731 * step - 98.7;
    const auto x = static_cast<float>(std::exp2(exponent));
    const double root = std::cbrt(double(x));
    cbrt_error = std::max(cbrt_error, std::abs(fast_cbrt(x) / root - 1));
    double_cbrt_error = std::max(double_cbrt_error, std::abs(fast_cbrt(double(x)) / root - 1));
    const double log2 = std::log2(double(x));
    log2_error = std::max(log2_error, std::abs(fast_log2(x) - log2) / (1 + std::abs(log2)));
    const auto argument = static_cast<float>(exponent);
    exp2_error =
        std::max(exp2_error, std::abs(fast_exp2(argument) / std::exp2(double(argument)) - 1));
    for (const float p : {0.1f, 0.7f, 1.0f}) {
      power_error = std::max(power_error, std::abs(fast_power(x, p) / std::pow(double(x), p) - 1) /
                                              (1 + std::abs(p * log2)));
    }
  }
  EXPECT_LT(cbrt_error, 3e-7);
  EXPECT_LT(double_cbrt_error, 1e-15);
  EXPECT_LT(log2_error, 2e-7);
  EXPECT_LT(exp2_error, 3e-7);
  EXPECT_LT(power_error, 4e-7);
  EXPECT_EQ(fast_power(0.0f, 0.7f), 0.0f);
}

// Sums of the taps on both sides and of those of one sign.
double sum_of(const FlipTaps& kernel) {
  return 2.0 * std::accumulate(kernel.taps.begin(), kernel.taps.end(), 0.0) - kernel.taps[0];
}

TEST(FlipFilters, AreNormalised) {
  const FlipFilters& filters = flip_filters();
  for (const FlipTaps& smooth : {filters.achromatic, filters.red_green, filters.blue_yellow[0],
                                 filters.blue_yellow[1], filters.gaussian}) {
    EXPECT_NEAR(sum_of(smooth), 1.0, 2e-7);
  }
  EXPECT_NEAR(filters.blue_yellow_weights[0] + filters.blue_yellow_weights[1], 1.0, 1e-7);
  EXPECT_NEAR(std::accumulate(filters.edge.taps.begin(), filters.edge.taps.end(), 0.0), 1.0, 2e-7);
  EXPECT_EQ(filters.edge.taps[0], 0.0f);
  double positive = 0, negative = 0;
  for (std::size_t k = 0; k < filters.point.taps.size(); ++k) {
    const double tap = (k == 0 ? 1.0 : 2.0) * filters.point.taps[k];
    (tap > 0 ? positive : negative) += tap;
  }
  EXPECT_NEAR(positive, 1.0, 2e-7);
  EXPECT_NEAR(negative, -1.0, 2e-7);
  // ceil(3 sigma) of the widest of either kind.
  EXPECT_EQ(filters.blue_yellow[0].radius, 10);
  EXPECT_EQ(filters.gaussian.radius, 9);
}

/// Floats round L*, a* and b* by some 2e-5 and their small differences with them.
constexpr double bound = 5e-6;

/// FLIP of two constant colours in linear RGB as displayed. There are no features, and no filter
/// changes a constant: the colour difference alone is left.
double flip_of_colours(const Rgb& reference, const Rgb& test) {
  const auto seen = [](const Rgb& rgb) {
    Lab lab = xyz_to_lab(rgb_to_xyz(rgb));
    lab.a *= 0.01 * lab.l;
    lab.b *= 0.01 * lab.l;
    return lab;
  };
  const auto power = [&](const Rgb& a, const Rgb& b) {
    const Lab x = seen(a), y = seen(b);
    return std::pow(std::abs(x.l - y.l) + std::hypot(x.a - y.a, x.b - y.b), 0.7);
  };
  const double largest = power({0, 1, 0}, {0, 0, 1});
  const double value = power(reference, test);
  const double knee = 0.4 * largest;
  return value < knee ? 0.95 * value / knee : 0.95 + 0.05 * (value - knee) / (largest - knee);
}

Image constant(int width, int height, const Rgb& rgb) {
  Image image(width, height, 3);
  for (std::size_t i = 0; i < image.values().size(); ++i) {
    image.values()[i] = static_cast<float>(rgb[i % 3]);
  }
  return image;
}

TEST(FlipLdr, OfConstantColoursIsTheirColourDifference) {
  // The exposure takes the reference's luminance to 1 and the clamp what is above.
  const auto flip = [](const Rgb& reference, const Rgb& test) {
    const Image r = constant(70, 13, reference);
    return value_of({r, constant(70, 13, test), all_of(r)}, "flip_ldr");
  };
  EXPECT_NEAR(flip({1, 1, 1}, {0.5, 0.5, 0.5}), flip_of_colours({1, 1, 1}, {0.5, 0.5, 0.5}), bound);
  EXPECT_NEAR(flip({1, 1, 1}, {0.98, 1.0, 0.97}), flip_of_colours({1, 1, 1}, {0.98, 1.0, 0.97}),
              bound);
  EXPECT_NEAR(flip({1, 1, 1}, {0, 0, 0}), flip_of_colours({1, 1, 1}, {0, 0, 0}), bound);
  EXPECT_NEAR(flip({0, 1, 0}, {0.1, 0, 0.2}),
              flip_of_colours({0, 1, 0}, {0.1 / 0.7152, 0, 0.2 / 0.7152}), bound);
  EXPECT_NEAR(flip({2, 2, 2}, {-1, 0.5, 3}), flip_of_colours({1, 1, 1}, {0, 0.25, 1}), bound);
  // The largest difference there is.
  EXPECT_NEAR(flip({0, 1, 0}, {0, 0, 1}), 1.0, bound);
}

TEST(FlipHdr, OfConstantColoursShowsTheReferenceAt85Percent) {
  const auto aces = [](double x) {
    x *= 0.6;
    return std::min(1.0, x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14));
  };
  double white = 0, above = 10;  // of the tone curve: aces(white) = 0.85
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (white + above);
    (aces(middle) < 0.85 ? white : above) = middle;
  }
  const Image reference = constant(20, 30, {4, 4, 4});
  for (const double factor : {0.0, 0.5, 0.99, 1.5, 1e4}) {
    const Image test = constant(20, 30, {4 * factor, 4, 4 * factor});
    const double shown = aces(factor * white);
    EXPECT_NEAR(value_of({reference, test, all_of(test)}, "flip_hdr"),
                flip_of_colours({0.85, 0.85, 0.85}, {shown, 0.85, shown}), bound)
        << factor;
  }
}

TEST(FlipHdr, IsTheLargestOfTheExposures) {
  // Five stops between the maximum and the median; what differs is far below the bright part and
  // shows only when that is overexposed.
  Image reference(40, 40, 3, 1.0f / 32);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 8; ++x) {
      for (int c = 0; c < 3; ++c) reference.at(x, y, c) = 1.0f;
    }
  }
  Image test = reference;
  for (int y = 0; y < 40; ++y) {
    for (int x = 20; x < 40; ++x) test.at(x, y, 0) *= 1.5f;
  }
  const ComparisonInput whole{reference, test, all_of(test)};
  EXPECT_GT(value_of(whole, "flip_hdr"), 2 * value_of(whole, "flip_ldr"));
}

TEST(FlipHdr, OfAReferenceThatIsMostlyBlackIsNotMeasured) {
  Image reference(20, 20, 3);
  for (int x = 0; x < 20; ++x) {
    for (int c = 0; c < 3; ++c) reference.at(x, 3, c) = 1;
  }
  const auto values = by_name({reference, reference, all_of(reference)});
  EXPECT_FALSE(values.at("flip_hdr").value.has_value());
  EXPECT_EQ(values.at("flip_hdr").reason,
            "the reference's median luminance is 0, so that there is no longest exposure");
  EXPECT_EQ(values.at("flip_ldr").value.value(), 0.0);
}

TEST(Flip, DoesNotSeeWhatIsMasked) {
  const Image mask = ragged_mask(90, 70);
  const Image reference = noise_image(90, 70, 1);
  const Image test = noise_image(90, 70, 2);
  Image other_reference = reference;
  Image other_test = test;
  for (int y = 0; y < 70; ++y) {
    for (int x = 0; x < 90; ++x) {
      if (mask.at(x, y) > 0.5f) continue;
      other_reference.at(x, y, 1) = not_a_number;
      other_test.at(x, y, 2) = infinite;
    }
  }
  for (const char* name : {"flip_ldr", "flip_hdr"}) {
    EXPECT_EQ(value_of({reference, test, mask}, name),
              value_of({other_reference, other_test, mask}, name));
    EXPECT_LT(by_name({reference, test, mask}).at(name).pixels, 90u * 70u);
  }
}

TEST(Flip, MaskedSurroundingsAreTheSameGrey) {
  // A constant image in a masked frame of the background's own grey is a constant image.
  const double grey = flip_background;
  const Image reference = constant(40, 40, {1, 1, 1});
  Image mask(40, 40, 1);
  for (int y = 12; y < 28; ++y) {
    for (int x = 12; x < 28; ++x) mask.at(x, y) = 1;
  }
  EXPECT_NEAR(srgb_encode(grey), 0.5, 1e-7);
  const Image test = constant(40, 40, {grey, grey, grey});
  // Near the frame the reference is darkened by it and gets an edge, which the test image has not.
  const double inner = flip_of_colours({1, 1, 1}, {grey, grey, grey});
  const double value = value_of({reference, test, mask}, "flip_ldr");
  EXPECT_GT(value, inner * 1.01);
  EXPECT_LE(value, 1.0);
}

FlipImage image_of(const Image& linear) {
  PreparedPair pair;
  pair.width = linear.width();
  pair.height = linear.height();
  pair.foreground.assign(linear.pixel_count(), 1.0f);
  Planes planes;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < linear.pixel_count(); ++i) {
      planes[c].push_back(linear.values()[3 * i + c]);
    }
  }
  return flip_image(pair, planes, linear_display(0.5));
}

Image transposed(const Image& image) {
  Image result(image.height(), image.width(), image.channels());
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int c = 0; c < image.channels(); ++c) result.at(y, x, c) = image.at(x, y, c);
    }
  }
  return result;
}

Image part_of(const Image& image, int left, int top, int width, int height) {
  Image result(width, height, image.channels());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < image.channels(); ++c) {
        result.at(x, y, c) = image.at(left + x, top + y, c);
      }
    }
  }
  return result;
}

double at(const Plane& plane, int width, int x, int y) {
  return plane[std::size_t(y) * std::size_t(width) + std::size_t(x)];
}

TEST(FlipMap, DoesNotDependOnTheTiles) {
  // Parts of an image, whose pixels lie elsewhere in the tiles, have the whole's map but for what
  // their borders reach.
  const Image reference = noise_image(150, 140, 3);
  const Image test = noise_image(150, 140, 4);
  const Plane whole = flip_map(image_of(reference), image_of(test));
  for (const auto& [left, top] : {std::pair(0, 0), std::pair(37, 51), std::pair(63, 1)}) {
    const int width = 80, height = 79;
    const Plane part = flip_map(image_of(part_of(reference, left, top, width, height)),
                                image_of(part_of(test, left, top, width, height)));
    double largest = 0;
    for (int y = flip_reach; y < height - flip_reach; ++y) {
      for (int x = flip_reach; x < width - flip_reach; ++x) {
        const double of_part = at(part, width, x, y);
        const double of_whole = at(whole, 150, left + x, top + y);
        largest = std::max(largest, std::abs(of_part - of_whole));
      }
    }
    EXPECT_LT(largest, 1e-6) << left << ' ' << top;
  }
}

TEST(FlipMap, IsSymmetricInTheImagesAndTheirAxes) {
  const Image reference = noise_image(75, 66, 5);
  const Image test = noise_image(75, 66, 6);
  const Plane map = flip_map(image_of(reference), image_of(test));
  EXPECT_EQ(map, flip_map(image_of(test), image_of(reference)));
  const Plane turned = flip_map(image_of(transposed(reference)), image_of(transposed(test)));
  for (int y = 0; y < 66; ++y) {
    for (int x = 0; x < 75; ++x) {
      const double here = at(map, 75, x, y);
      ASSERT_NEAR(here, at(turned, 66, y, x), 2e-5) << x << ' ' << y;
      ASSERT_GE(here, 0.0);
      ASSERT_LE(here, 1.0);
    }
  }
}

TEST(FlipMap, EvenSurfacesHaveNoFeatures) {
  // The border goes on outside of the image, so that a constant image is even up to it.
  const Plane map = flip_map(image_of(constant(67, 21, {0.3, 0.5, 0.9})),
                             image_of(constant(67, 21, {0.31, 0.5, 0.8})));
  const double expected = flip_of_colours({0.15, 0.25, 0.45}, {0.155, 0.25, 0.4});
  for (const float value : map) ASSERT_NEAR(value, expected, bound);
}

TEST(FlipMap, FeaturesRaiseTheDifference) {
  // The same colour difference once everywhere and once along lines: FLIP minds the lines more than
  // their share after the eye's blur.
  const Image reference = constant(60, 60, {1, 1, 1});
  Image lines = reference;
  Image blurred = reference;
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 60; ++x) {
      for (int c = 0; c < 3; ++c) {
        if (x % 12 == 0) lines.at(x, y, c) = 0.4f;
        blurred.at(x, y, c) = 1.0f - 0.6f / 12;
      }
    }
  }
  const auto mean = [](const Plane& map) {
    return std::accumulate(map.begin(), map.end(), 0.0) / double(map.size());
  };
  EXPECT_GT(mean(flip_map(image_of(reference), image_of(lines))),
            1.2 * mean(flip_map(image_of(reference), image_of(blurred))));
}

}  // namespace
}  // namespace occlab
