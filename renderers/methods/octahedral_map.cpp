#include "renderers/methods/octahedral_map.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <vector>

#include "renderers/scene/parallel.h"
#include "renderers/shared/equirect.h"
#include "renderers/shared/octahedral.h"
#include "renderers/shared/packed_radiance.h"

namespace occlab {
namespace {

/// Radiance over an octahedral texel, at across x across points.
struct TexelRadiance {
  glm::vec3 mean{0.0f};  ///< over the solid angle
  float contrast = 0.0f;
};

TexelRadiance texel_radiance(const Image& equirect, int side, glm::ivec2 place, int across) {
  glm::vec3 sum(0.0f);
  glm::vec3 least(std::numeric_limits<float>::infinity());
  glm::vec3 most(0.0f);
  float weights = 0.0f;
  for (int i = 0; i < across * across; ++i) {
    const glm::vec2 within = (glm::vec2(i % across, i / across) + 0.5f) / float(across);
    const glm::vec3 point = octahedral_point((glm::vec2(place) + within) / float(side));
    const float distance = length(point);
    const float solid_angle = 1.0f / (distance * distance * distance);
    const glm::vec2 uv = equirect_uv(point / distance);
    const int x = std::min(int(uv.x * float(equirect.width())), equirect.width() - 1);
    const int y = std::min(int(uv.y * float(equirect.height())), equirect.height() - 1);
    const auto texel = equirect.pixel(x, y);
    const glm::vec3 radiance(texel[0], texel[1], texel[2]);
    sum += solid_angle * radiance;
    weights += solid_angle;
    least = min(least, radiance);
    most = max(most, radiance);
  }
  const glm::vec3 contrast = most - least;
  return {sum / weights, std::max({contrast.x, contrast.y, contrast.z})};
}

float mean_value(const Image& image) {
  double sum = 0.0;
  for (const float value : image.values()) sum += double(value);
  return float(sum / double(image.values().size()));
}

/// The outlines of what is bright, such as a sun of few texels, are looked at closely.
Image map_of_side(const Image& equirect, int side) {
  constexpr int points_across = 4;
  constexpr int points_across_outlines = 32;
  const float bright = mean_value(equirect);
  Image map(side, side, 3);
  parallel_for(std::size_t(side), [&](std::size_t row) {
    for (int x = 0; x < side; ++x) {
      const glm::ivec2 place(x, int(row));
      TexelRadiance texel = texel_radiance(equirect, side, place, points_across);
      if (texel.contrast > bright) {
        texel = texel_radiance(equirect, side, place, points_across_outlines);
      }
      const glm::vec3 held = unpack_radiance(pack_radiance(texel.mean));
      for (int c = 0; c < 3; ++c) map.at(x, int(row), c) = held[c];
    }
  });
  return map;
}

}  // namespace

int octahedral_side(const Environment& environment) {
  const double sphere_across_degrees = std::sqrt(4.0 * double(pi)) * 180.0 / double(pi);
  if (environment.blur_degrees > 0.0f) {
    const double texels = 10.0 * sphere_across_degrees / double(environment.blur_degrees);
    return int(std::clamp(std::bit_ceil(unsigned(std::ceil(texels))), 64u, 2048u));
  }
  // Texels of about the size of the probe's own at its equator; small ones keep their outlines.
  return int(std::clamp(std::bit_ceil(unsigned(environment.texels.width())) / 2, 512u, 2048u));
}

Image octahedral_map(const Environment& environment) {
  return map_of_side(environment.texels, octahedral_side(environment));
}

}  // namespace occlab
