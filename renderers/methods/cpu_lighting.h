#pragma once

#include <array>

#include "renderers/methods/lighting.h"
#include "renderers/methods/pass_constants.h"

namespace occlab {

/// What the passes read light from, for the CPU: the same texels and the same look-ups. All
/// directions and points are in view space.
class CpuLighting {
 public:
  /// Makes whatever `lighting`, which outlives this, has not made yet.
  CpuLighting(const Lighting& lighting, const PassConstants& constants);

  /// The octahedral probe's nearest texels in 16 directions, on their way into the cache: each is
  /// three floats, RGB.
  using Texels = std::array<const float*, lane_count>;
  Texels probe_texels(const Lanes3& directions) const;
  static std::array<Lanes, 3> radiance(const Texels& texels);
  /// L_c(d, angle), linear between texels and levels.
  glm::vec3 cone_radiance(glm::vec3 d, float angle) const;
  /// Of the whole probe on a surface with normal n.
  glm::vec3 unoccluded_irradiance(glm::vec3 n) const;
  /// Order-4 SH of the probe, c[env] of [S3HO eq. 4].
  const ShRgb& sh() const { return sh_; }
  const std::vector<PunctualLight>& lights() const { return lights_; }
  /// The Hanning window's factors of the four bands.
  glm::vec4 window() const { return window_; }
  int cone_angle() const { return cone_angle_; }

 private:
  const Image& probe_;
  const std::vector<Image>& cones_;
  const ShRgb& sh_;
  glm::mat3 probe_from_view_;
  std::vector<PunctualLight> lights_;
  glm::vec4 window_;
  int cone_angle_;
};

}  // namespace occlab
