#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "renderers/scene/scene.h"

namespace occlab {

/// The texture's value at `uv`, which is finite: red, green, blue and alpha as far as the image has
/// them; missing colours are 0, a missing alpha is 1. What the G-buffer's pass reads, too
/// (shared/surface_texture.h).
glm::vec4 texture_at(const Image& texture, const TextureSampling& sampling, glm::vec2 uv);

/// Where a ray meets a surface.
struct SurfaceHit {
  int instance = 0;             ///< index into Scene::instances
  std::uint32_t triangle = 0;   ///< of the instance's mesh
  glm::vec2 barycentric{0.0f};  ///< weights of the triangle's second and third corner
};

/// The reflectance rho there, linear RGB: the material's factor times its texture.
glm::vec3 albedo_at(const Scene& scene, const SurfaceHit& hit);

}  // namespace occlab
