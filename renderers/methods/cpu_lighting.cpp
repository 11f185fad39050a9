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

glm::vec3 CpuLighting::probe_radiance(glm::vec3 s) const {
  const glm::vec2 at =
      equirect_uv(probe_from_view_ * s) * glm::vec2(probe_.width(), probe_.height());
  return texel(probe_, std::clamp(int(at.x), 0, probe_.width() - 1),
               std::clamp(int(at.y), 0, probe_.height() - 1));
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
