#include "renderers/scene/surface_texture.h"

#include "renderers/shared/surface_texture.h"

namespace occlab {

glm::vec4 texture_at(const Image& texture, const TextureSampling& sampling, glm::vec2 uv) {
  const TextureFootprint at =
      texture_footprint(uv, {texture.width(), texture.height()}, {sampling.wrap_u, sampling.wrap_v},
                        sampling.nearest);
  glm::vec4 value(0.0f, 0.0f, 0.0f, 1.0f);
  for (int c = 0; c < texture.channels(); ++c) {
    const float top =
        glm::mix(texture.at(at.low.x, at.low.y, c), texture.at(at.high.x, at.low.y, c), at.share.x);
    const float bottom = glm::mix(texture.at(at.low.x, at.high.y, c),
                                  texture.at(at.high.x, at.high.y, c), at.share.x);
    value[c] = glm::mix(top, bottom, at.share.y);
  }
  return value;
}

glm::vec3 albedo_at(const Scene& scene, const SurfaceHit& hit) {
  const Instance& instance = scene.instances[std::size_t(hit.instance)];
  const Mesh& mesh = scene.meshes[std::size_t(instance.mesh)];
  const Material& material = scene.materials[std::size_t(mesh.material)];
  if (!material.albedo_texture) return material.albedo;
  const glm::vec2 b = hit.barycentric;
  const std::uint32_t* corner = &mesh.indices[3 * std::size_t(hit.triangle)];
  const glm::vec2 uv = (1.0f - b.x - b.y) * mesh.uvs[corner[0]] + b.x * mesh.uvs[corner[1]] +
                       b.y * mesh.uvs[corner[2]];
  const Image& texture = scene.textures[std::size_t(*material.albedo_texture)];
  return material.albedo * glm::vec3(texture_at(texture, material.sampling, uv));
}

}  // namespace occlab
