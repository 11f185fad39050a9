#include "renderers/trace/probe_table.h"

#include "renderers/shared/equirect.h"

namespace occlab {

ProbeTable::ProbeTable(const Environment& environment, const EnvironmentSampler& sampler)
    : width(environment.texels.width()),
      height(environment.texels.height()),
      probe_from_world(environment.probe_from_world) {
  const Image& image = environment.texels;
  const glm::mat3 world_from_probe = glm::transpose(probe_from_world);
  texels.reserve(image.pixel_count());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const glm::vec2 uv((float(x) + 0.5f) / float(width), (float(y) + 0.5f) / float(height));
      texels.push_back({image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2),
                        sampler.pdf(world_from_probe * equirect_direction(uv))});
    }
  }
}

}  // namespace occlab
