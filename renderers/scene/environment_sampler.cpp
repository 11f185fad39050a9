#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <span>

#include "renderers/scene/environment.h"

namespace occlab {
namespace {

struct Interval {
  int index;
  double fraction;  ///< position within the interval, [0, 1)
};

/// The interval of running sums that `u` of their total falls into; never an empty one.
Interval find_interval(std::span<const double> sums, double u) {
  const double target = u * sums.back();
  const auto above = std::ranges::upper_bound(sums, target);
  const auto index = std::size_t(above - sums.begin()) - 1;
  return {int(index), (target - sums[index]) / (sums[index + 1] - sums[index])};
}

}  // namespace

EnvironmentSampler::EnvironmentSampler(const Environment& environment)
    : environment_(&environment) {
  const Image& texels = environment.texels;
  row_cdf_.push_back(0.0);
  column_cdf_.reserve(std::size_t(texels.height()) * (std::size_t(texels.width()) + 1));
  for (int y = 0; y < texels.height(); ++y) {
    double sum = 0.0;
    column_cdf_.push_back(sum);
    for (int x = 0; x < texels.width(); ++x) {
      const auto texel = texels.pixel(x, y);
      sum += (double(texel[0]) + double(texel[1]) + double(texel[2])) / 3.0;
      column_cdf_.push_back(sum);
    }
    row_cdf_.push_back(row_cdf_.back() + sum * texel_solid_angle(texels, y));
  }
}

float EnvironmentSampler::texel_pdf(glm::ivec2 texel) const {
  const Image& texels = environment_->texels;
  const auto row = std::size_t(texel.y);
  const double* columns = &column_cdf_[row * (std::size_t(texels.width()) + 1)];
  const double row_sum = columns[texels.width()];
  if (!(row_sum > 0.0) || black()) return 0.0f;
  const double p_row = (row_cdf_[row + 1] - row_cdf_[row]) / row_cdf_.back();
  const double p_column = (columns[texel.x + 1] - columns[texel.x]) / row_sum;
  return float(p_row * p_column / texel_solid_angle(texels, texel.y));
}

float EnvironmentSampler::pdf(glm::vec3 direction_world) const {
  return texel_pdf(environment_->texel(direction_world));
}

EnvironmentSampler::Sample EnvironmentSampler::sample(float u1, float u2) const {
  assert(!black());
  const Image& texels = environment_->texels;
  const Interval row = find_interval(row_cdf_, u1);
  const std::size_t row_length = std::size_t(texels.width()) + 1;
  const Interval column = find_interval(
      std::span(column_cdf_).subspan(std::size_t(row.index) * row_length, row_length), u2);
  const glm::ivec2 texel(column.index, row.index);

  const glm::mat3 world_from_probe = glm::transpose(environment_->probe_from_world);
  const auto direction_at = [&](double across, double down) {
    const double phi = 2.0 * std::numbers::pi * ((texel.x + across) / texels.width() - 0.5);
    const double step = std::numbers::pi / texels.height();
    const double z = std::lerp(std::cos(texel.y * step), std::cos((texel.y + 1) * step), down);
    const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
    return glm::normalize(world_from_probe * glm::vec3(r * std::cos(phi), z, r * std::sin(phi)));
  };
  glm::vec3 direction = direction_at(column.fraction, row.fraction);
  // Rounding can carry a direction on a texel's edge into the neighbour, whose density differs.
  if (environment_->texel(direction) != texel) direction = direction_at(0.5, 0.5);
  return {direction, environment_->radiance(direction), texel_pdf(texel)};
}

}  // namespace occlab
