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

std::array<glm::vec3, lane_count> CpuLighting::probe_radiance(
    const std::array<glm::vec3, lane_count>& directions) const {
  Lanes3 d;
  for (int i = 0; i < lane_count; ++i) {
    const glm::vec3 in_probe = probe_from_view_ * directions[std::size_t(i)];
    d.x[i] = in_probe.x;
    d.y[i] = in_probe.y;
    d.z[i] = in_probe.z;
  }
  Lanes column;
  Lanes row;
  for (int i = 0; i < lane_count; ++i) {  // on its own, for the vectoriser
    const glm::vec2 uv = equirect_uv(glm::vec3(d.x[i], d.y[i], d.z[i]));
    column[i] = uv.x * float(probe_.width());
    row[i] = uv.y * float(probe_.height());
  }
  std::array<glm::vec3, lane_count> radiance;
  for (int i = 0; i < lane_count; ++i) {
    radiance[std::size_t(i)] = texel(probe_, std::clamp(int(column[i]), 0, probe_.width() - 1),
                                     std::clamp(int(row[i]), 0, probe_.height() - 1));
  }
  return radiance;
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
