#pragma once

#include <array>
#include <glm/glm.hpp>

#include "renderers/methods/representation.h"

namespace occlab {

/// A blocker as a sender of light. View space.
struct Sender {
  float share = 0.0f;         ///< 1 - V; 0 where nothing blocks, and the rest has no meaning
  glm::vec3 to_sender{0.0f};  ///< p' - p
  glm::vec3 normal{0.0f};     ///< unit
  glm::vec3 albedo{0.0f};
  glm::vec3 lit{0.0f};  ///< radiance of the direct light, where the bounce reads it
};

/// One bounce: what the light of blockers is accumulated into, and how irradiance is read back out
/// of it. The CPU's form, from the headers that the shaders include.
struct Bounce {
  static constexpr int most_channels = 27;
  /// The values of a pixel; the first `channels` are used.
  using Values = std::array<float, most_channels>;

  int channels = 0;
  /// Blockers send what the framebuffer, lit by the representation alone, shows of them. The values
  /// are then of the representation's own kind, and are added to it before the filter.
  bool reads_lit = false;
  float storage_error = 0.0f;  ///< as Representation::storage_error
  /// Adds a sender; `factor` is (1 - V) f.
  void (*accumulate)(Values& sums, const Sender& sender, float factor) = nullptr;
  /// E_ind, not clamped.
  glm::vec3 (*irradiance)(const Values& values, const ShadedPoint& point,
                          const CpuLighting& lighting) = nullptr;
  /// Sums as they are stored; null where they are stored as they are.
  void (*result)(Values& sums) = nullptr;
  /// An image of the values into the occlusion pass's targets behind those of the representation;
  /// null where a bounce has a pass of its own.
  void (*upload)(const Image& values, const Framebuffer& target) = nullptr;
  /// Adds layers of what is stored, where the parameters ask for them; null for none.
  void (*add_layers)(const Framebuffer& target, const ParameterSet& parameters,
                     Layers& layers) = nullptr;
};

}  // namespace occlab
