#include "harness/verify/cycles_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>

#include "harness/statistics.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr double confidence = 0.95;
constexpr double largest_z = 38.0;  // beyond which a normal tail is 0 in double precision
constexpr int tile_pixels = 16;

void require_comparable(Seeds seeds, const char* name, const Image& mask) {
  if (seeds.size() < 4) {
    throw InputError(
        fmt::format("comparison: {} renderings of {}; accepted: 4 or more", seeds.size(), name));
  }
  for (const Image& image : seeds) {
    if (!image.same_size(mask) || image.channels() != seeds[0].channels()) {
      throw InputError(fmt::format("comparison: {} is {}x{} with {} channels beside {}x{} with {}",
                                   name, image.width(), image.height(), image.channels(),
                                   mask.width(), mask.height(), seeds[0].channels()));
    }
    for (int y = 0; y < mask.height(); ++y) {
      for (int x = 0; x < mask.width(); ++x) {
        if (mask.at(x, y) < 0.5f) continue;
        for (const float value : image.pixel(x, y)) {
          if (!std::isfinite(value)) {
            throw InputError(fmt::format("comparison: {} has the value {} at pixel ({}, {})", name,
                                         value, x, y));
          }
        }
      }
    }
  }
}

/// The mean of a quantity over the seeds, the variance of that mean, its degrees of freedom.
struct Estimate {
  double mean = 0.0;
  double variance = 0.0;
  double degrees = 1.0;
};

Estimate estimate(std::span<const double> of_each_seed) {
  return {mean(of_each_seed), variance(of_each_seed) / double(of_each_seed.size()),
          double(of_each_seed.size() - 1)};
}

/// Of a difference of two estimates whose variances enter with these parts [Welch 1947].
double welch_degrees(double part_a, double degrees_a, double part_b, double degrees_b) {
  const double sum = part_a + part_b;
  return sum * sum / (part_a * part_a / degrees_a + part_b * part_b / degrees_b);
}

struct Rectangle {
  int x0, y0, x1, y1;
};

/// The sum over the mask within the rectangle, for each seed.
std::vector<double> sums(Seeds seeds, const Image& mask, const Rectangle& area, int channel) {
  std::vector<double> all;
  for (const Image& image : seeds) {
    double sum = 0.0;
    for (int y = area.y0; y < area.y1; ++y) {
      for (int x = area.x0; x < area.x1; ++x) {
        if (mask.at(x, y) > 0.5f) sum += double(image.at(x, y, channel));
      }
    }
    all.push_back(sum);
  }
  return all;
}

std::size_t count(const Image& mask, const Rectangle& area) {
  std::size_t pixels = 0;
  for (int y = area.y0; y < area.y1; ++y) {
    for (int x = area.x0; x < area.x1; ++x) pixels += mask.at(x, y) > 0.5f;
  }
  return pixels;
}

BlockDifference compare_block(Seeds a, Seeds b, const Image& mask, const Rectangle& area,
                              int channel) {
  BlockDifference block{
      .x = area.x0, .y = area.y0, .channel = channel, .pixels = count(mask, area)};
  const Estimate ours = estimate(sums(a, mask, area, channel));
  const Estimate theirs = estimate(sums(b, mask, area, channel));
  if (ours.mean == 0.0 && theirs.mean == 0.0) return block;
  if (theirs.mean == 0.0) {
    block.difference = std::numeric_limits<double>::infinity();
    return block;
  }
  const double ratio = ours.mean / theirs.mean;
  block.difference = ratio - 1.0;
  // First-order propagation; the relative errors it is used for are below a hundredth.
  const double part_a = ours.variance / (theirs.mean * theirs.mean);
  const double part_b = ratio * ratio * theirs.variance / (theirs.mean * theirs.mean);
  if (part_a + part_b > 0.0) {
    const double degrees = welch_degrees(part_a, ours.degrees, part_b, theirs.degrees);
    block.error = student_quantile(0.5 + 0.5 * confidence, degrees) * std::sqrt(part_a + part_b);
  }
  return block;
}

void compare_blocks(Seeds a, Seeds b, const Image& mask, RendererComparison& result) {
  const int channels = a[0].channels();
  for (int y = 0; y < mask.height(); y += block_size) {
    for (int x = 0; x < mask.width(); x += block_size) {
      const Rectangle area{x, y, std::min(x + block_size, mask.width()),
                           std::min(y + block_size, mask.height())};
      if (count(mask, area) < min_block_pixels) {
        ++result.blocks_left_out;
        continue;
      }
      for (int channel = 0; channel < channels; ++channel) {
        result.blocks.push_back(compare_block(a, b, mask, area, channel));
      }
    }
  }
  const Rectangle all{0, 0, mask.width(), mask.height()};
  result.whole = compare_block(a, b, mask, all, 0);
  for (int channel = 1; channel < channels; ++channel) {
    const BlockDifference block = compare_block(a, b, mask, all, channel);
    if (block.limit() > result.whole.limit()) result.whole = block;
  }
}

Estimate pixel_estimate(Seeds seeds, int x, int y, int channel, std::vector<double>& values) {
  values.clear();
  for (const Image& image : seeds) values.push_back(double(image.at(x, y, channel)));
  return estimate(values);
}

/// Of a pixel that may be outside the mask and not finite.
float plain_mean(Seeds seeds, int x, int y, int channel) {
  double sum = 0.0;
  for (const Image& image : seeds) sum += double(image.at(x, y, channel));
  return float(sum / double(seeds.size()));
}

/// ZeroOneSamples says why. Does nothing where the samples are not 0 or 1.
void bound_variances(Estimate& a, Estimate& b, ZeroOneSamples samples) {
  if (samples.a == 0 || samples.b == 0) return;
  const double all_a = double(samples.a) * (a.degrees + 1.0);
  const double all_b = double(samples.b) * (b.degrees + 1.0);
  const double share = (a.mean * all_a + b.mean * all_b) / (all_a + all_b);
  const double rarer = std::min(share, 1.0 - share);
  const double of_one = share * (1.0 - share);
  if (rarer * double(samples.a) < 1.0) a.variance = std::max(a.variance, of_one / all_a);
  if (rarer * double(samples.b) < 1.0) b.variance = std::max(b.variance, of_one / all_b);
}

/// The standard normal value whose tail is that of the difference under Student's t.
double z_value(const Estimate& a, const Estimate& b) {
  const double difference = a.mean - b.mean;
  if (difference == 0.0) return 0.0;
  double z = largest_z;
  if (const double sum = a.variance + b.variance; sum > 0.0) {
    const double degrees = welch_degrees(a.variance, a.degrees, b.variance, b.degrees);
    const double tail = student_cdf(-std::abs(difference) / std::sqrt(sum), degrees);
    z = std::min(largest_z, -normal_quantile(tail));
  }
  return std::copysign(z, difference);
}

void compare_pixels(Seeds a, Seeds b, const Image& mask, ZeroOneSamples samples,
                    RendererComparison& result) {
  const int channels = a[0].channels();
  for (Image* image : {&result.mean_a, &result.mean_b, &result.relative_difference, &result.z}) {
    *image = Image(mask.width(), mask.height(), channels);
  }
  double variance_a = 0.0, variance_b = 0.0, sum_b = 0.0, part_of_a = 0.0;
  std::size_t beyond = 0, noisy = 0;
  std::vector<double> scratch;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      for (int c = 0; c < channels; ++c) {
        result.mean_a.at(x, y, c) = plain_mean(a, x, y, c);
        result.mean_b.at(x, y, c) = plain_mean(b, x, y, c);
        if (mask.at(x, y) < 0.5f) continue;
        Estimate ours = pixel_estimate(a, x, y, c, scratch);
        Estimate theirs = pixel_estimate(b, x, y, c, scratch);
        bound_variances(ours, theirs, samples);
        const double z = z_value(ours, theirs);
        result.z.at(x, y, c) = float(z);
        result.relative_difference.at(x, y, c) =
            theirs.mean != 0.0 ? float(ours.mean / theirs.mean - 1.0) : 0.0f;
        beyond += std::abs(z) > 3.0;
        variance_a += ours.variance;
        variance_b += theirs.variance;
        sum_b += theirs.mean;
        if (const double sum = ours.variance + theirs.variance; sum > 0.0) {
          part_of_a += ours.variance / sum;
          ++noisy;
        }
      }
    }
  }
  const auto values = double(result.pixels * std::size_t(channels));
  result.share_beyond_3_sigma = double(beyond) / values;
  // A share's variance grows by 1 + (n - 1) r for n values of correlation r [Kish 1965]; that of
  // two normal values' exceedances is below that of the values. Channels count as one.
  const double correlation = noisy ? part_of_a / double(noisy) : 0.0;
  result.independent_pixels = double(result.pixels) / (1.0 + (tile_pixels - 1) * correlation);
  if (sum_b > 0.0) {
    result.rms_error_a = std::sqrt(variance_a / values) / (sum_b / values);
    result.rms_error_b = std::sqrt(variance_b / values) / (sum_b / values);
  }
}

glm::vec3 vector_at(const Image& image, int x, int y) {
  return {image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
}

}  // namespace

double BlockDifference::limit() const { return std::abs(difference) + error; }

RendererComparison compare_renderers(Seeds a, Seeds b, const Image& mask, ZeroOneSamples samples) {
  require_comparable(a, "ours", mask);
  require_comparable(b, "Cycles'", mask);
  if (a[0].channels() != b[0].channels()) {
    throw InputError(
        fmt::format("comparison: {} channels beside {}", a[0].channels(), b[0].channels()));
  }
  RendererComparison result;
  result.pixels = count(mask, {0, 0, mask.width(), mask.height()});
  if (result.pixels == 0) {
    throw InputError("comparison: no pixel is away from silhouettes; render more pixels");
  }
  compare_blocks(a, b, mask, result);
  compare_pixels(a, b, mask, samples, result);
  return result;
}

Image away_from_silhouettes(const Image& position_view, const Image& geometric_normal_view,
                            const Image& surface_mask) {
  // Neighbours on one surface lie near each other's tangent plane (within 30 degrees) and face
  // nearly the same way (within 45 degrees).
  constexpr float most_out_of_plane = 0.5f;
  constexpr float least_normal_cosine = 0.7f;
  const auto one_surface = [&](int x0, int y0, int x1, int y1) {
    if (surface_mask.at(x1, y1) < 0.5f) return false;
    const glm::vec3 normal = vector_at(geometric_normal_view, x0, y0);
    const glm::vec3 step = vector_at(position_view, x1, y1) - vector_at(position_view, x0, y0);
    return dot(normal, vector_at(geometric_normal_view, x1, y1)) >= least_normal_cosine &&
           std::abs(dot(normal, step)) <= most_out_of_plane * length(step);
  };
  Image result(surface_mask.width(), surface_mask.height(), 1);
  for (int y = 0; y < result.height(); ++y) {
    for (int x = 0; x < result.width(); ++x) {
      bool away = surface_mask.at(x, y) > 0.5f;
      for (int y1 = std::max(y - 1, 0); away && y1 <= std::min(y + 1, result.height() - 1); ++y1) {
        for (int x1 = std::max(x - 1, 0); away && x1 <= std::min(x + 1, result.width() - 1); ++x1) {
          away = one_surface(x, y, x1, y1);
        }
      }
      result.at(x, y) = away ? 1.0f : 0.0f;
    }
  }
  return result;
}

}  // namespace occlab
