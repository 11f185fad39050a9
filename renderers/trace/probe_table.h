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

  int width;
  int height;
  glm::mat3 probe_from_world;
  std::vector<Texel> texels;
};

}  // namespace occlab
