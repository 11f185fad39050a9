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
  for (int y = 0; y <= texels.height(); ++y) {
    row_cosine_.push_back(std::cos(y * std::numbers::pi / texels.height()));
  }
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
  const auto row_index = std::size_t(row.index);

  const glm::mat3 world_from_probe = glm::transpose(environment_->probe_from_world);
  const auto direction_at = [&](double across, double down) {
    const auto phi = float(2.0 * std::numbers::pi * ((texel.x + across) / texels.width() - 0.5));
    const double z = std::lerp(row_cosine_[row_index], row_cosine_[row_index + 1], down);
    const auto r = float(std::sqrt(std::max(0.0, 1.0 - z * z)));
    return glm::normalize(world_from_probe *
                          glm::vec3(r * std::cos(phi), float(z), r * std::sin(phi)));
  };
  glm::vec3 direction = direction_at(column.fraction, row.fraction);
  // Rounding can carry a direction near a texel's edge into the neighbour, whose density differs.
  const auto near_edge = [](double fraction) { return std::fabs(fraction - 0.5) > 0.48; };
  const bool near_pole = std::fabs((environment_->probe_from_world * direction).y) > 0.99f;
  if ((near_pole || near_edge(column.fraction) || near_edge(row.fraction)) &&
      environment_->texel(direction) != texel) {
    direction = direction_at(0.5, 0.5);
  }
  const auto value = texels.pixel(texel.x, texel.y);
  return {direction, {value[0], value[1], value[2]}, texel_pdf(texel)};
}

}  // namespace occlab
