// Metrics that look at the neighbourhood of a pixel.
#include <algorithm>
#include <cmath>

#include "harness/metrics/colour.h"
#include "harness/metrics/gaussian.h"
#include "harness/metrics/metric_functions.h"
#include "harness/metrics/parallel.h"

namespace occlab {
namespace {

constexpr int ssim_radius = 5;

std::vector<double> luma(const PreparedPair& pair, const Displayed& displayed) {
  std::vector<double> result(pair.foreground.size());
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = luminance({displayed.srgb[0][i], displayed.srgb[1][i], displayed.srgb[2][i]});
  }
  return result;
}

std::vector<double> product(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> result(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) result[i] = a[i] * b[i];
  return result;
}

// 1 where the window of the given radius lies in the image and in the foreground as a whole.
std::vector<char> whole_windows(const PreparedPair& pair, int radius) {
  std::vector<char> across(pair.foreground.size(), 0);
  std::vector<char> whole(pair.foreground.size(), 0);
  const auto index = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(pair.width) +
           static_cast<std::size_t>(x);
  };
  for (int y = 0; y < pair.height; ++y) {
    int run = 0;  // of foreground pixels that ends at x
    for (int x = 0; x < pair.width; ++x) {
      run = pair.foreground[index(x, y)] != 0.0f ? run + 1 : 0;
      if (run > 2 * radius) across[index(x - radius, y)] = 1;
    }
  }
  std::vector<int> runs(static_cast<std::size_t>(pair.width), 0);
  for (int y = 0; y < pair.height; ++y) {
    for (int x = 0; x < pair.width; ++x) {
      int& run = runs[static_cast<std::size_t>(x)];
      run = across[index(x, y)] != 0 ? run + 1 : 0;
      if (run > 2 * radius) whole[index(x, y - radius)] = 1;
    }
  }
  return whole;
}

}  // namespace

// Wang, Bovik, Sheikh and Simoncelli 2004, "Image quality assessment", eq. 13-16.
Measured measure_ssim(const PreparedPair& pair) {
  if (!pair.reference_displayed) return {std::nullopt, no_exposure, 0};
  const std::vector<char> whole = whole_windows(pair, ssim_radius);
  const auto windows = static_cast<std::size_t>(std::count(whole.begin(), whole.end(), 1));
  if (windows == 0) return {std::nullopt, "no 11 x 11 window lies wholly in the foreground", 0};

  constexpr double c1 = 0.01 * 0.01;
  constexpr double c2 = 0.03 * 0.03;
  const std::vector<double> taps = gaussian_taps(1.5, ssim_radius);
  const auto smooth = [&](const std::vector<double>& plane) {
    return blur(plane, pair.width, pair.height, taps);
  };
  const std::vector<double> x = luma(pair, *pair.test_displayed);
  const std::vector<double> r = luma(pair, *pair.reference_displayed);
  const std::vector<double> mean_x = smooth(x);
  const std::vector<double> mean_r = smooth(r);
  const std::vector<double> mean_xx = smooth(product(x, x));
  const std::vector<double> mean_rr = smooth(product(r, r));
  const std::vector<double> mean_xr = smooth(product(x, r));

  double sum = 0.0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (whole[i] == 0) continue;
    const double means = mean_x[i] * mean_r[i];
    const double squares = mean_x[i] * mean_x[i] + mean_r[i] * mean_r[i];
    const double covariance = mean_xr[i] - means;
    const double variances = mean_xx[i] + mean_rr[i] - squares;
    sum += (2.0 * means + c1) * (2.0 * covariance + c2) / ((squares + c1) * (variances + c2));
  }
  return {sum / static_cast<double>(windows), {}, windows};
}

Measured high_frequency_residual(const PreparedPair& pair, double sigma) {
  // Beyond 4 sigma lies 6e-5 of the kernel's weight.
  const std::vector<double> taps = gaussian_taps(sigma, static_cast<int>(std::ceil(4.0 * sigma)));
  const Plane weight = blur(pair.foreground, pair.width, pair.height, taps);
  double sum = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    Plane error(pair.foreground.size());
    for (std::size_t i = 0; i < error.size(); ++i) {
      error[i] = pair.test[c][i] - pair.reference[c][i];
    }
    const Plane low = blur(error, pair.width, pair.height, taps);
    sum += sum_over_rows(pair.height, [&](int y) {
      const auto width = static_cast<std::size_t>(pair.width);
      const std::size_t begin = static_cast<std::size_t>(y) * width;
      double row = 0.0;
      for (std::size_t i = begin; i < begin + width; ++i) {
        if (pair.foreground[i] == 0.0f) continue;
        const double high = double(error[i]) - double(low[i]) / double(weight[i]);
        row += high * high;
      }
      return row;
    });
  }
  return {std::sqrt(sum / (3.0 * static_cast<double>(pair.foreground_count))),
          {},
          pair.foreground_count};
}

}  // namespace occlab
