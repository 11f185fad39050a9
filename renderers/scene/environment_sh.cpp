#include <array>
#include <cmath>
#include <numbers>

#include "renderers/scene/environment.h"
#include "renderers/scene/parallel.h"

namespace occlab {
namespace {

constexpr std::size_t coefficients = 16;
using RgbSums = std::array<std::array<double, coefficients>, 3>;

/// The nodes of two-point Gauss-Legendre quadrature on [0, 1].
constexpr std::array<double, 2> nodes = {0.5 - 0.5 * std::numbers::inv_sqrt3,
                                         0.5 + 0.5 * std::numbers::inv_sqrt3};

void add_scaled(std::array<double, coefficients>& sum, const Sh4& a, double weight) {
  const std::array<const vec4*, 4> parts = {&a.c0, &a.c1, &a.c2, &a.c3};
  for (std::size_t i = 0; i < coefficients; ++i) {
    sum[i] += weight * double((*parts[i / 4])[int(i % 4)]);
  }
}

Sh4 to_sh4(const std::array<double, coefficients>& sum) {
  const auto part = [&](std::size_t i) {
    return vec4(float(sum[i]), float(sum[i + 1]), float(sum[i + 2]), float(sum[i + 3]));
  };
  return sh4(part(0), part(4), part(8), part(12));
}

}  // namespace

ShRgb project_sh(const Environment& environment, const glm::mat3& world_from_space) {
  const Image& texels = environment.texels;
  const glm::dmat3 space_from_probe =
      glm::transpose(glm::dmat3(environment.probe_from_world) * glm::dmat3(world_from_space));

  // cos phi and sin phi at both nodes of every column.
  std::vector<glm::dvec2> azimuths;
  for (int x = 0; x < texels.width(); ++x) {
    for (const double node : nodes) {
      const double phi = 2.0 * std::numbers::pi * ((x + node) / texels.width() - 0.5);
      azimuths.emplace_back(std::cos(phi), std::sin(phi));
    }
  }

  std::vector<RgbSums> rows(std::size_t(texels.height()), RgbSums{});
  parallel_for(rows.size(), [&](std::size_t row) {
    const int y = int(row);
    std::array<glm::dvec2, 2> polar;  // cos theta, sin theta
    for (std::size_t i = 0; i < 2; ++i) {
      const double theta = std::numbers::pi * (y + nodes[i]) / texels.height();
      polar[i] = {std::cos(theta), std::sin(theta)};
    }
    // Weights of the nodes follow sin theta and sum to the texel's exact solid angle.
    const double scale = texel_solid_angle(texels, y) / (2.0 * (polar[0].y + polar[1].y));
    for (int x = 0; x < texels.width(); ++x) {
      Sh4 mean = sh_zero();
      for (std::size_t i = 0; i < 2; ++i) {
        for (std::size_t k = 0; k < 2; ++k) {
          const glm::dvec2 azimuth = azimuths[2 * std::size_t(x) + k];
          const glm::dvec3 probe(polar[i].y * azimuth.x, polar[i].x, polar[i].y * azimuth.y);
          mean = sh_add_scaled(mean, sh_basis(vec3(space_from_probe * probe)), float(polar[i].y));
        }
      }
      const auto radiance = texels.pixel(x, y);
      for (std::size_t c = 0; c < 3; ++c) add_scaled(rows[row][c], mean, scale * radiance[c]);
    }
  });

  RgbSums total{};
  for (const RgbSums& row : rows) {
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < coefficients; ++i) total[c][i] += row[c][i];
    }
  }
  return ShRgb{to_sh4(total[0]), to_sh4(total[1]), to_sh4(total[2])};
}

}  // namespace occlab
