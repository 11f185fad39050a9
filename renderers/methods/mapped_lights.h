#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderers/gl/shadow_map.h"
#include "renderers/scene/environment.h"
#include "renderers/shared/lights.h"

namespace occlab {

/// A light and the maps that tell what it reaches. World space.
struct MappedLight {
  PunctualLight light;
  bool is_virtual = false;  ///< as incident_virtual_light() of shared/shadow_map.h has it
  LightProjection projection;
};

/// What depth maps take for the scene's size: a sphere around all of it.
struct SceneSphere {
  glm::vec3 center_world{0.0f};
  float radius = 0.0f;
};
SceneSphere sphere_around(const Scene& scene);

/// Point lights have the maps of a cube, directional ones a parallel map of the whole scene, spots
/// one map of their cone; but a cone of more than 120 degrees across has a cube's.
std::vector<MappedLight> mapped_lights(std::span<const Light> lights, const SceneSphere& sphere);

/// An environment as directional lights of the same sum of light [SSDO sec. 5]: `count` directions
/// in proportion to the texels' light, E_perp = L / (count pdf). Empty if the environment is black.
std::vector<MappedLight> environment_lights(const Environment& environment, int count,
                                            std::uint64_t seed, const SceneSphere& sphere);

/// Virtual point lights: where the light of punctual lights first arrives, on patches drawn in
/// proportion to the flux that they reflect [Keller 1997; Dachsbacher and Stamminger 2005; SSDO
/// sec. 5]. Reflective shadow maps have `side` texels a side. Empty if no light arrives anywhere.
std::vector<MappedLight> virtual_lights(std::span<const MappedLight> lights, int count, int side,
                                        std::uint64_t seed, const Scene& scene,
                                        const GpuScene& gpu_scene, ProgramCache& programs);

}  // namespace occlab
