#pragma once

#include <array>
#include <glm/glm.hpp>

#include "renderers/gl/texture.h"
#include "renderers/methods/cpu_lighting.h"
#include "renderers/methods/visibility_source.h"
#include "renderers/scene/image_io.h"

namespace occlab {

/// One direction that an occlusion pass adds up, in any orthonormal space.
struct SampledDirection {
  glm::vec3 direction;
  float cosine;        ///< n.s
  float visibility;    ///< V
  glm::vec3 radiance;  ///< L_in, only where the representation reads it
};

struct Bounce;

/// What a visible direction is accumulated into, and how light is read back out of it: the CPU's
/// form of an occlusion pass and its lighting pass, from the headers that the shaders include.
struct Representation {
  /// The largest number of values a pixel has; the first `channels` are used.
  using Values = std::array<float, 16>;

  int channels = 0;
  bool reads_radiance = false;  ///< looks light up, and marches to lights, while sampling
  /// A stored value is off by up to this times itself (or a little near 0): half of a half float's
  /// last place, or 0.
  float storage_error = 0.0f;
  /// Linear in V times the radiance, or in V alone where it does not read radiance.
  void (*accumulate)(Values& sums, const SampledDirection& sample) = nullptr;
  /// Sums of directions given in a frame become those of the directions in the space that the
  /// frame's columns are given in; null where they do not depend on the space.
  void (*turn)(Values& sums, const glm::mat3& frame) = nullptr;
  /// Sums over `count` directions become the representation, as the occlusion pass writes it.
  void (*result)(Values& sums, int count) = nullptr;
  /// E (not clamped) of the probe and the lights.
  glm::vec3 (*irradiance)(const Values& values, const ShadedPoint& point,
                          const CpuLighting& lighting) = nullptr;
  /// An image of the representation into the occlusion pass's targets, and back.
  void (*upload)(const Image& values, const Framebuffer& target) = nullptr;
  Image (*download)(const Framebuffer& target, int channels) = nullptr;
  /// Adds the method's own layers.
  void (*add_layers)(const Image& values, Layers& layers) = nullptr;
  /// What blockers send, in addition; null for direct light alone.
  const Bounce* bounce = nullptr;
};

}  // namespace occlab
