// Convolutions of an equirect image with kernels that depend on the angle only.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <numbers>

#include "renderers/scene/environment.h"
#include "renderers/scene/parallel.h"

namespace occlab {
namespace {

constexpr double pi_d = std::numbers::pi;

/// A kernel as a function of sin^2(angle / 2), which stays exact for small angles, zero beyond
/// `support`.
struct ZonalKernel {
  std::function<double(double half_angle_sin_squared)> value;
  double support;  ///< radians
};

double sine_squared(double x) { return std::sin(x) * std::sin(x); }

double angle_of(double half_angle_sin_squared) {
  return 2.0 * std::asin(std::sqrt(std::min(1.0, half_angle_sin_squared)));
}

/// The kernel between the rows of one image. A row pair's values depend on the column distance
/// only, so one row of values serves every texel of the row.
class RowKernel {
 public:
  RowKernel(int width, int height, ZonalKernel kernel)
      : width_(width), height_(height), kernel_(std::move(kernel)) {
    limit_ = sine_squared(0.5 * std::min(kernel_.support, pi_d));
    for (int dx = 0; dx <= width / 2; ++dx) column_term_.push_back(sine_squared(pi_d * dx / width));
    for (int y = 0; y < height; ++y) sin_theta_.push_back(std::sin(theta(y)));
  }

  int first_row(int y) const { return std::max(0, y - reach()); }
  int last_row(int y) const { return std::min(height_ - 1, y + reach()); }

  /// Values for column distances 0, 1, ...; at most width / 2, the antipodal column, inclusive.
  void values(int row, int other, std::vector<double>& out) const {
    out.clear();
    const double row_term = sine_squared(0.5 * (theta(row) - theta(other)));
    const double scale = sin_theta_[std::size_t(row)] * sin_theta_[std::size_t(other)];
    for (const double column_term : column_term_) {
      const double s = row_term + scale * column_term;  // haversine formula
      if (s > limit_) break;
      out.push_back(kernel_.value(s));
    }
  }

  /// How many columns lie at distance `dx`.
  int multiplicity(std::size_t dx) const {
    return dx == 0 || dx == std::size_t(width_) / 2 ? 1 : 2;
  }

 private:
  double theta(int y) const { return pi_d * (y + 0.5) / height_; }
  int reach() const {
    return int(std::min(double(height_), std::ceil(kernel_.support * height_ / pi_d)));
  }

  int width_;
  int height_;
  ZonalKernel kernel_;
  double limit_ = 0.0;
  std::vector<double> column_term_;  // sin^2(delta phi / 2)
  std::vector<double> sin_theta_;
};

/// sums[y][k]: the kernel summed over the columns, between row y and row first_row(y) + k.
std::vector<std::vector<double>> row_sums(const RowKernel& kernel, int height) {
  std::vector<std::vector<double>> sums{std::size_t(height)};
  parallel_for(sums.size(), [&](std::size_t index) {
    const int y = int(index);
    std::vector<double> values;
    for (int other = kernel.first_row(y); other <= kernel.last_row(y); ++other) {
      kernel.values(y, other, values);
      double sum = 0.0;
      for (std::size_t dx = 0; dx < values.size(); ++dx) {
        sum += kernel.multiplicity(dx) * values[dx];
      }
      sums[index].push_back(sum);
    }
  });
  return sums;
}

std::vector<double> solid_angles(const Image& texels) {
  std::vector<double> result;
  for (int y = 0; y < texels.height(); ++y) result.push_back(texel_solid_angle(texels, y));
  return result;
}

/// target[i] += weight * (left[i] + right[i]), the innermost loop.
void add_pair(float* __restrict target, const float* left, const float* right, float weight,
              std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) target[i] += weight * (left[i] + right[i]);
}

/// out(row, x) = sum over texels (other, x') of row_scale[row] other_scale[other] kernel source.
Image convolve(const Image& source, const RowKernel& kernel, const std::vector<double>& row_scale,
               const std::vector<double>& other_scale) {
  const std::size_t width = std::size_t(source.width());
  const std::size_t half = width / 2;
  const std::size_t row_floats = 3 * width;
  // Every row with half a turn repeated on either side, so that the inner loop never wraps.
  const std::size_t padded_floats = row_floats + 6 * half;
  std::vector<float> padded(padded_floats * std::size_t(source.height()));
  for (int y = 0; y < source.height(); ++y) {
    for (std::size_t i = 0; i < width + 2 * half; ++i) {
      const auto texel = source.pixel(int((i + width - half) % width), y);
      std::ranges::copy(texel, &padded[padded_floats * std::size_t(y) + 3 * i]);
    }
  }

  Image result(source.width(), source.height(), 3);
  parallel_for(std::size_t(source.height()), [&](std::size_t index) {
    const int y = int(index);
    float* target = result.pixel(0, y).data();
    std::vector<double> values;
    for (int other = kernel.first_row(y); other <= kernel.last_row(y); ++other) {
      kernel.values(y, other, values);
      const float* row = &padded[padded_floats * std::size_t(other) + 3 * half];
      const double scale = row_scale[index] * other_scale[std::size_t(other)];
      for (std::size_t dx = 0; dx < values.size(); ++dx) {
        // add_pair adds two columns; a distance with one column gets it twice at half the weight.
        const auto weight = float(0.5 * kernel.multiplicity(dx) * scale * values[dx]);
        const float* left = row - 3 * dx;
        const float* right = dx == half ? left : row + 3 * dx;
        add_pair(target, left, right, weight, row_floats);
      }
    }
  });
  return result;
}

/// Scales a with a_i sum_j sums_ij a_j omega_j = 1: the symmetric kernel a_i K_ij a_j then keeps
/// constants, and by its symmetry energy too. Sinkhorn's iteration in its symmetric, damped form
/// [Knight, Ruiz and Ucar 2014].
std::vector<double> balance(const RowKernel& kernel, const std::vector<std::vector<double>>& sums,
                            const std::vector<double>& omega) {
  std::vector<double> a(omega.size(), 1.0);
  for (int iteration = 0; iteration < 1000; ++iteration) {
    std::vector<double> next(a.size());
    double worst = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      double sum = 0.0;
      const auto first = std::size_t(kernel.first_row(int(i)));
      for (std::size_t k = 0; k < sums[i].size(); ++k) {
        sum += sums[i][k] * a[first + k] * omega[first + k];
      }
      worst = std::max(worst, std::abs(a[i] * sum - 1.0));
      next[i] = std::sqrt(a[i] / sum);
    }
    if (worst < 1e-9) break;
    a = std::move(next);
  }
  return a;
}

}  // namespace

Image resample_area(const Image& texels, int width) {
  assert(width >= 2 && width % 2 == 0);
  const int height = width / 2;
  // Overlaps [first, last) of an output interval with input intervals, and their measure.
  struct Part {
    int source;
    double weight;
  };
  const auto parts = [](int output, int outputs, int inputs, const auto& measure) {
    std::vector<Part> result;
    const double low = double(output) / outputs;
    const double high = double(output + 1) / outputs;
    const int last = std::min(inputs - 1, int(std::ceil(high * inputs)) - 1);
    double total = 0.0;
    for (int source = int(low * inputs); source <= last; ++source) {
      const double from = std::max(low, double(source) / inputs);
      const double to = std::min(high, double(source + 1) / inputs);
      if (!(to > from)) continue;
      result.push_back({source, measure(from, to)});
      total += result.back().weight;
    }
    for (Part& part : result) part.weight /= total;
    return result;
  };
  std::vector<std::vector<Part>> columns;
  for (int x = 0; x < width; ++x) {
    columns.push_back(parts(x, width, texels.width(), [](double a, double b) { return b - a; }));
  }
  Image result(width, height, 3);
  parallel_for(std::size_t(height), [&](std::size_t row) {
    const auto rows = parts(int(row), height, texels.height(), [](double a, double b) {
      return std::cos(pi_d * a) - std::cos(pi_d * b);
    });
    for (int x = 0; x < width; ++x) {
      glm::dvec3 sum(0.0);
      for (const Part& down : rows) {
        for (const Part& across : columns[std::size_t(x)]) {
          const auto texel = texels.pixel(across.source, down.source);
          sum += down.weight * across.weight * glm::dvec3(texel[0], texel[1], texel[2]);
        }
      }
      for (int c = 0; c < 3; ++c) result.at(x, int(row), c) = float(sum[c]);
    }
  });
  return result;
}

Image prefilter_gaussian(const Image& texels, float sigma_degrees) {
  assert(sigma_degrees > 0.0f && texels.width() == 2 * texels.height());
  const double sigma = pi_d / 180.0 * double(sigma_degrees);
  const int wanted_height = std::max(32, int(std::ceil(std::min(4.0 * pi_d / sigma, 1e6))));
  const Image source =
      wanted_height < texels.height() ? resample_area(texels, 2 * wanted_height) : texels;

  const auto gaussian = [sigma](double s) {
    const double angle = angle_of(s);
    return std::exp(-angle * angle / (2.0 * sigma * sigma));
  };
  const RowKernel kernel(source.width(), source.height(), {gaussian, 5.0 * sigma});
  const std::vector<double> omega = solid_angles(source);
  const std::vector<double> a = balance(kernel, row_sums(kernel, source.height()), omega);
  std::vector<double> other_scale(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) other_scale[i] = a[i] * omega[i];
  return convolve(source, kernel, a, other_scale);
}

ConePrefilter prefilter_cones(const Environment& environment, int levels, int width) {
  assert(levels >= 1 && width >= 16 && width % 2 == 0);
  const Image source = resample_area(environment.texels, width);
  const std::vector<double> omega = solid_angles(source);
  const double texel_angle = pi_d / source.height();

  ConePrefilter result;
  for (int level = 0; level < levels; ++level) {
    const double alpha = 0.5 * pi_d * (level + 1) / levels;
    const double inside = sine_squared(0.5 * std::max(0.0, alpha - 0.5 * texel_angle));
    const auto cone = [=](double s) {
      const double cosine = std::max(0.0, 1.0 - 2.0 * s);
      if (s <= inside) return cosine;
      return cosine * std::clamp((alpha - angle_of(s)) / texel_angle + 0.5, 0.0, 1.0);
    };
    const RowKernel kernel(source.width(), source.height(), {cone, alpha + 0.5 * texel_angle});
    const auto sums = row_sums(kernel, source.height());
    std::vector<double> row_scale(omega.size());
    for (std::size_t i = 0; i < omega.size(); ++i) {
      const auto first = std::size_t(kernel.first_row(int(i)));
      double integral = 0.0;
      for (std::size_t k = 0; k < sums[i].size(); ++k) integral += sums[i][k] * omega[first + k];
      row_scale[i] = (1.0 + std::cos(alpha)) / integral;
    }
    result.levels.push_back(convolve(source, kernel, row_scale, omega));
  }
  return result;
}

}  // namespace occlab
