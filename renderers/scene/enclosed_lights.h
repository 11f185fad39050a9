#pragma once

#include <string>
#include <vector>

#include "renderers/scene/scene.h"

namespace occlab {

/// A light that is shut in.
struct EnclosedLight {
  std::string light;
  std::string mesh;  ///< what it is inside of
};

/// How often the surfaces of a mesh, its primitives taken together, wind around a point: the sum of
/// its triangles' signed solid angles over 4 pi [Van Oosterom and Strackee 1983, eq. 8]. Inside of
/// a closed mesh 1, or -1 where its triangles are clockwise from outside; outside of it 0; in
/// between near an open one.
double winding_number(const Mesh& mesh, glm::dvec3 point_object);

/// The scene's point and spot lights that are inside of a closed mesh without holes (alpha) while
/// `eye_world` is outside of it, with the first such mesh: they light nothing that is seen from
/// there. What a room's walls enclose together with the eye is no such light.
std::vector<EnclosedLight> enclosed_lights(const Scene& scene, glm::vec3 eye_world);

}  // namespace occlab
