#include "renderers/methods/cpu_lighting.h"

#include <algorithm>

#include "renderers/shared/equirect.h"

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

}  // namespace

CpuLighting::CpuLighting(const Lighting& lighting, const PassConstants& constants)
    : probe_(lighting.environment().texels),
      cones_(lighting.cones()),
      sh_(lighting.sh_view()),
      probe_from_view_(lighting.probe_from_view()),
      lights_(lighting.lights_view()),
      window_(sh_hanning_window(constants.hanning_width)),
      cone_angle_(constants.cone_angle) {}

CpuLighting::Texels CpuLighting::probe_texels(const Lanes3& directions) const {
  Texels texels;
  for (const int half : half_lanes) {
    const Int8 index =
        equirect_index8(probe_from_view_, directions, half, probe_.width(), probe_.height());
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
