#include "harness/metrics/gaussian.h"

#include <algorithm>
#include <cmath>

#include "harness/metrics/parallel.h"

namespace occlab {

std::vector<double> gaussian_taps(double sigma, int radius) {
  std::vector<double> taps;
  double sum = 0.0;
  for (int i = 0; i <= radius; ++i) {
    taps.push_back(std::exp(-0.5 * i * i / (sigma * sigma)));
    sum += i == 0 ? taps.back() : 2.0 * taps.back();
  }
  for (double& tap : taps) tap /= sum;
  return taps;
}

template <typename T>
std::vector<T> blur(const std::vector<T>& plane, int width, int height,
                    const std::vector<double>& taps) {
  const auto columns = static_cast<std::size_t>(width);
  const std::size_t radius = taps.size() - 1;
  const std::vector<T> weights(taps.begin(), taps.end());

  // The loops run over taps outside and columns inside: that is what the compiler vectorises.
  std::vector<T> across(plane.size());
  for_each_row(height, [&](int y) {
    thread_local std::vector<T> padded;
    padded.assign(columns + 2 * radius, T(0));
    const T* source = plane.data() + static_cast<std::size_t>(y) * columns;
    std::copy_n(source, columns, padded.data() + radius);
    T* __restrict target = across.data() + static_cast<std::size_t>(y) * columns;
    for (std::size_t x = 0; x < columns; ++x) target[x] = weights[0] * source[x];
    for (std::size_t k = 1; k <= radius; ++k) {
      const T weight = weights[k];
      const T* __restrict left = padded.data() + radius - k;
      const T* __restrict right = padded.data() + radius + k;
      for (std::size_t x = 0; x < columns; ++x) target[x] += weight * (left[x] + right[x]);
    }
  });

  std::vector<T> result(plane.size());
  const std::vector<T> nothing(columns, T(0));
  const auto row_or_nothing = [&](std::ptrdiff_t y) {
    const bool inside = y >= 0 && y < height;
    return inside ? across.data() + static_cast<std::size_t>(y) * columns : nothing.data();
  };
  for_each_row(height, [&](int y) {
    const T* __restrict source = row_or_nothing(y);
    T* __restrict target = result.data() + static_cast<std::size_t>(y) * columns;
    for (std::size_t x = 0; x < columns; ++x) target[x] = weights[0] * source[x];
    for (std::size_t k = 1; k <= radius; ++k) {
      const T weight = weights[k];
      const auto offset = static_cast<std::ptrdiff_t>(k);
      const T* __restrict above = row_or_nothing(y - offset);
      const T* __restrict below = row_or_nothing(y + offset);
      for (std::size_t x = 0; x < columns; ++x) target[x] += weight * (above[x] + below[x]);
    }
  });
  return result;
}

template std::vector<float> blur(const std::vector<float>&, int, int, const std::vector<double>&);
template std::vector<double> blur(const std::vector<double>&, int, int, const std::vector<double>&);

}  // namespace occlab
