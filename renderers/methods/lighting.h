#pragma once

#include <optional>

#include "renderers/gl/texture.h"
#include "renderers/scene/environment.h"
#include "renderers/scene/view.h"
#include "renderers/shared/cones.h"
#include "renderers/shared/lights.h"

namespace occlab {

inline constexpr int cone_level_width = 128;

/// A probe and punctual lights, ready for the passes of one view. What a method does not ask for
/// is not made.
class Lighting {
 public:
  Lighting(Environment environment, std::vector<Light> lights, const View& view);

  const Environment& environment() const { return environment_; }
  const std::vector<Light>& lights() const { return lights_; }

  /// Turns a view-space direction into probe space.
  glm::mat3 probe_from_view() const;
  /// Order-4 SH of the probe in view space: c[env] of [S3HO eq. 4].
  const ShRgb& sh_view() const;
  /// octahedral_map() of the probe, probe space.
  const Image& octahedral_probe() const;
  /// Its texels row by row as packed_radiance.h has them.
  const TexelBuffer& octahedral_texels() const;
  /// L_c at alpha_k = (k+1)/8 pi/2, probe space. The last level is E_unoccluded / pi. The first and
  /// last rows are beyond the poles, for filtering only.
  const std::vector<Image>& cones() const;
  const Texture& cone_texture() const;
  /// The lights as the passes have them, view space.
  std::vector<PunctualLight> lights_view() const;
  /// std140 array of lights_view(); one unused entry if there is no light.
  const Buffer& light_buffer() const;
  const Buffer& sh_buffer() const;

 private:
  Environment environment_;
  std::vector<Light> lights_;
  View view_;
  mutable std::optional<ShRgb> sh_view_;
  mutable std::optional<Image> octahedral_probe_;
  mutable std::optional<TexelBuffer> octahedral_texels_;
  mutable std::optional<std::vector<Image>> cones_;
  mutable std::optional<Texture> cone_texture_;
  mutable std::optional<Buffer> light_buffer_;
  mutable std::optional<Buffer> sh_buffer_;
};

}  // namespace occlab
