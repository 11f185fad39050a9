#pragma once

#include <cmath>

#include "renderers/scene/scene.h"
#include "renderers/shared/lights.h"

namespace occlab {

/// A scene's light in the form that C++ and GLSL share, in the space given by `space_from_world`.
inline PunctualLight punctual_light(const Light& light,
                                    const glm::mat4& space_from_world = glm::mat4(1.0f)) {
  const glm::vec3 position(space_from_world * glm::vec4(light.position_world, 1.0f));
  const glm::vec3 direction(space_from_world * glm::vec4(light.direction_world, 0.0f));
  return {glm::vec4(position, float(light.type)),
          glm::vec4(glm::normalize(direction), std::cos(light.outer_cone_angle)),
          glm::vec4(light.intensity, std::cos(light.inner_cone_angle))};
}

}  // namespace occlab
