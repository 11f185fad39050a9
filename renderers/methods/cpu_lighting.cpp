#include "renderers/methods/cpu_lighting.h"

#include <algorithm>

#include "renderers/shared/equirect.h"
#include "renderers/shared/octahedral.h"

namespace occlab {
namespace {

glm::vec3 texel(const Image& image, int x, int y) {
  return {image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
}

/// Bilinear look-up that wraps in u and clamps in v, as the texture does.
glm::vec3 bilinear(const Image& image, glm::vec2 uv) {
  const glm::vec2 at = uv * glm::vec2(image.width(), image.height()) - 0.5f;
  const glm::vec2 lower = glm::floor(at);
  const glm::vec2 share = at - lower;
  const auto column = [&](int x) { return (x + image.width()) % image.width(); };
  const auto row = [&](int y) { return std::clamp(y, 0, image.height() - 1); };
  const int x = int(lower.x);
  const int y = int(lower.y);
  const glm::vec3 above =
      glm::mix(texel(image, column(x), row(y)), texel(image, column(x + 1), row(y)), share.x);
  const glm::vec3 below = glm::mix(texel(image, column(x), row(y + 1)),
                                   texel(image, column(x + 1), row(y + 1)), share.x);
  return glm::mix(above, below, share.y);
}

/// shared/octahedral.h's octahedral_texel() of its octahedral_uv(), as an index, for eight of the
/// directions and without branches.
Int8 octahedral_index8(const glm::mat3& m, const Lanes3& direction, int half, int side) {
  const Float8 dx = load8(direction.x, half);
  const Float8 dy = load8(direction.y, half);
  const Float8 dz = load8(direction.z, half);
  const Float8 x = m[0][0] * dx + m[1][0] * dy + m[2][0] * dz;
  const Float8 y = m[0][1] * dx + m[1][1] * dy + m[2][1] * dz;
  const Float8 z = m[0][2] * dx + m[1][2] * dy + m[2][2] * dz;
  const Float8 scale = 1.0f / (abs8(x) + abs8(y) + abs8(z));
  const Float8 px = x * scale;
  const Float8 pz = z * scale;
  const auto folded = [](Float8 other, Float8 own) {
    const Float8 size = 1.0f - abs8(other);
    return own < 0.0f ? -size : size;
  };
  const float scale_to_texels = octahedral_scale(side);
  const auto texel = [&](Float8 p) {
    return __builtin_convertvector((0.5f + 0.5f * p) * scale_to_texels, Int8);
  };
  return texel(y < 0.0f ? folded(px, pz) : pz) * side + texel(y < 0.0f ? folded(pz, px) : px);
}

}  // namespace

CpuLighting::CpuLighting(const Lighting& lighting, const PassConstants& constants)
    : probe_(lighting.octahedral_probe()),
      cones_(lighting.cones()),
      sh_(lighting.sh_view()),
      probe_from_view_(lighting.probe_from_view()),
      lights_(lighting.lights_view()),
      window_(sh_hanning_window(constants.hanning_width)),
      cone_angle_(constants.cone_angle) {}

CpuLighting::Texels CpuLighting::probe_texels(const Lanes3& directions) const {
  Texels texels;
  for (const int half : half_lanes) {
    const Int8 index = octahedral_index8(probe_from_view_, directions, half, probe_.width());
    for (std::size_t i = 0; i < 8; ++i) {
      const float* texel = probe_.values().data() + 3 * std::size_t(index[i]);
      _mm_prefetch(texel, _MM_HINT_T0);
      texels[std::size_t(half) + i] = texel;
    }
  }
  return texels;
}

std::array<Lanes, 3> CpuLighting::radiance(const Texels& texels) {
  std::array<Lanes, 3> rgb;
  for (std::size_t c = 0; c < rgb.size(); ++c) {
    for (std::size_t i = 0; i < texels.size(); ++i) rgb[c].v[i] = texels[i][c];
  }
  return rgb;
}

glm::vec3 CpuLighting::cone_radiance(glm::vec3 d, float angle) const {
  glm::vec2 uv = equirect_uv(probe_from_view_ * d);
  uv.y = cone_row(uv.y, float(cones_.front().height()));
  const float level = cone_level(angle);
  const int lower = int(level);
  const int upper = std::min(lower + 1, cone_levels - 1);
  return glm::mix(bilinear(cones_[std::size_t(lower)], uv),
                  bilinear(cones_[std::size_t(upper)], uv), level - float(lower));
}

glm::vec3 CpuLighting::unoccluded_irradiance(glm::vec3 n) const {
  return pi * cone_radiance(n, 0.5f * pi);
}

}  // namespace occlab
