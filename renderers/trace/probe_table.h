#pragma once

#include <vector>

#include "renderers/scene/environment.h"
#include "renderers/trace/packet.h"

namespace occlab {

/// A probe's radiance and the density with which the sampler draws it, one look-up for both.
struct ProbeTable {
  struct alignas(16) Texel {
    float r, g, b;
    float pdf;  ///< per solid angle
  };

  ProbeTable(const Environment& environment, const EnvironmentSampler& sampler);

  /// The texels of eight unit directions, probe space: equirect_uv() without branches.
  Int8 index(Float8 x, Float8 y, Float8 z) const {
    const Float8 u = 0.5f + atan2_8(z, x) * float(0.5 / 3.14159265358979);
    // Not the arccosine of y, as in shared/equirect.h.
    const Float8 v = atan2_8(sqrt8(x * x + z * z), y) * float(1.0 / 3.14159265358979);
    const auto clamped = [](Float8 value, int size) {
      const Int8 i = __builtin_convertvector(value * float(size), Int8);
      const Int8 least = i > 0 ? i : Int8{};
      return least < size ? least : Int8{} + (size - 1);
    };
    return clamped(v, height) * width + clamped(u, width);
  }

  int width;
  int height;
  glm::mat3 probe_from_world;
  std::vector<Texel> texels;
};

}  // namespace occlab
