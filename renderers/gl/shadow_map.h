#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "renderers/gl/gbuffer.h"

namespace occlab {

/// How the maps of one light are projected. Light space has the light at its origin (of a
/// directional one: a point beyond the whole scene); each face looks along the -Z of its own space
/// and is the square [low, high]^2 of the tangents x/-z and y/-z or, of parallel rays, of x and y
/// in scene units. A point belongs to the face along whose -Z it is farthest.
struct LightProjection {
  glm::mat4 light_from_world{1.0f};             ///< rigid
  std::vector<glm::mat3> face_from_light = {};  ///< rotations; 1 to most_faces
  float low = -1.0f;
  float high = 1.0f;
  bool parallel = false;  ///< rays of a directional light
  float nearest = 0.0f;   ///< scene units; surfaces nearer than this do not count
  float farthest = 0.0f;  ///< scene units; of parallel rays only

  static constexpr int most_faces = 6;
  int faces() const { return int(face_from_light.size()); }
};

/// All directions: the six faces of a cube.
LightProjection cube_projection(glm::vec3 position_world, float nearest);

/// Directions within 90 degrees of `axis_world`: the three faces of a cube's corner, widened to
/// twice their size on the outer sides, where they would otherwise end above the horizon.
LightProjection half_space_projection(glm::vec3 position_world, glm::vec3 axis_world,
                                      float nearest);

/// Directions within `half_angle` (radians, less than pi/2) of `axis_world`: one face.
LightProjection cone_projection(glm::vec3 position_world, glm::vec3 axis_world, float half_angle,
                                float nearest);

/// Parallel rays that travel along `direction_world` through a sphere: one face.
LightProjection parallel_projection(glm::vec3 direction_world, glm::vec3 center_world,
                                    float radius);

/// Maps of a light's faces. Used for one light after the other.
class ShadowMaps {
 public:
  /// Throws DeviceError naming shadow_map_side if the device does not take textures of that side.
  ShadowMaps(int side, int faces);

  int side() const { return distance_.width(); }
  int faces() const { return int(targets_.size()); }

  /// Draws all faces of a projection, which are at most faces().
  void draw(const LightProjection& projection, const Scene& scene, const GpuScene& gpu_scene,
            ProgramCache& programs) const;

  /// R32F, a layer a face: the distance from the light to the first surface along its ray, of
  /// parallel rays from the plane through light space's origin; no_surface where there is none.
  const Texture& distance() const { return distance_; }
  static constexpr float no_surface = 3e38f;

 private:
  Texture distance_;
  Texture depth_;
  std::vector<LayerFramebuffer> targets_;
};

/// What a light sees through one face [Dachsbacher and Stamminger 2005]: images of side x side
/// pixels. Positions and normals are in the face's space, normals on the light's side; `mask` is 1
/// where a surface is seen.
GBufferImages reflective_shadow_map(const LightProjection& projection, int face, int side,
                                    const Scene& scene, const GpuScene& gpu_scene,
                                    ProgramCache& programs);

}  // namespace occlab
