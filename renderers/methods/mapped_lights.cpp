#include "renderers/methods/mapped_lights.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "renderers/scene/punctual.h"
#include "renderers/shared/shadow_map.h"
#include "renderers/trace/point_sequence.h"

namespace occlab {
namespace {

/// Of the sphere around the scene: surfaces nearer to a light than this do not count, as the
/// reference's rays start somewhat above the surface.
constexpr float nearest_share = 1e-4f;

/// A wider cone's single map would have next to no texels in its middle.
constexpr float widest_half_angle = std::numbers::pi_v<float> / 3.0f;

/// The seed's sequences.
enum Purpose : std::uint32_t { purpose_environment = 17, purpose_virtual };

LightProjection projection_of(const Light& light, const SceneSphere& sphere) {
  const float nearest = nearest_share * sphere.radius;
  const glm::vec3 direction = glm::normalize(light.direction_world);
  if (light.type == LightType::directional) {
    return parallel_projection(direction, sphere.center_world, sphere.radius);
  }
  if (light.type == LightType::spot && light.outer_cone_angle <= widest_half_angle) {
    return cone_projection(light.position_world, direction, light.outer_cone_angle, nearest);
  }
  return cube_projection(light.position_world, nearest);
}

/// A patch of the first surfaces that a light sees.
struct Patch {
  glm::vec3 position_world;
  glm::vec3 normal_world;
  glm::vec3 flux;  ///< Phi, what it reflects
};

/// The patches of all lights' reflective shadow maps, and sums to draw them by.
class Patches {
 public:
  explicit Patches(int side) : side_(side) {}

  void add(const MappedLight& light, const Scene& scene, const GpuScene& gpu_scene,
           ProgramCache& programs) {
    const LightProjection& projection = light.projection;
    for (int face = 0; face < projection.faces(); ++face) {
      const GBufferImages seen =
          reflective_shadow_map(projection, face, side_, scene, gpu_scene, programs);
      const glm::mat4 world_from_face = glm::inverse(
          glm::mat4(projection.face_from_light[std::size_t(face)]) * projection.light_from_world);
      for (int y = 0; y < side_; ++y) {
        for (int x = 0; x < side_; ++x) add_texel(light, seen, world_from_face, x, y);
        row_sums_.push_back(sums_.back());
      }
    }
  }

  double total() const { return sums_.back(); }

  /// u and v in [0, 1). A patch's probability is its mean flux over total().
  const Patch& draw(float u, float v) const {
    const std::size_t row = interval(row_sums_, 0, row_sums_.size(), double(u));
    const std::size_t first = row * std::size_t(side_);
    return patches_[interval(sums_, first, first + std::size_t(side_) + 1, double(v))];
  }

  static double mean(glm::vec3 flux) {
    return (double(flux.x) + double(flux.y) + double(flux.z)) / 3.0;
  }

 private:
  /// The interval [i, i + 1] of running sums first..last-1 that `u` of their span falls into; never
  /// an empty one.
  static std::size_t interval(const std::vector<double>& sums, std::size_t first, std::size_t last,
                              double u) {
    const auto begin = sums.begin() + std::ptrdiff_t(first);
    const auto end = sums.begin() + std::ptrdiff_t(last);
    const double target =
        std::min(std::lerp(*begin, *(end - 1), u), std::nextafter(*(end - 1), 0.0));
    const auto above = std::upper_bound(begin, end, target);
    return std::size_t(above - sums.begin()) - 1;
  }

  void add_texel(const MappedLight& light, const GBufferImages& seen,
                 const glm::mat4& world_from_face, int x, int y) {
    Patch patch{};
    if (seen.mask.at(x, y) > 0.0f) {
      const auto at = [&](const Image& image) {
        const auto value = image.pixel(x, y);
        return glm::vec3(value[0], value[1], value[2]);
      };
      const glm::vec3 position = at(seen.position_view);
      const glm::mat3 rotation(world_from_face);
      patch.position_world = glm::vec3(world_from_face * glm::vec4(position, 1.0f));
      patch.normal_world = glm::normalize(rotation * at(seen.normal_view));
      patch.flux = at(seen.albedo) * arriving_flux(light, patch.position_world, position);
    }
    patches_.push_back(patch);
    sums_.push_back(sums_.back() + mean(patch.flux));
  }

  /// Through a texel: E_perp times its cross-section where it meets the surface.
  glm::vec3 arriving_flux(const MappedLight& light, glm::vec3 position_world,
                          glm::vec3 position_face) const {
    const LightProjection& projection = light.projection;
    const float width = (projection.high - projection.low) / float(side_);
    const IncidentLight incident = incident_light(light.light, position_world);
    if (projection.parallel) return incident.irradiance * (width * width);
    // A texel's solid angle is width^2 cos^3 of the angle to the face's axis.
    const float cosine = -position_face.z / glm::length(position_face);
    const float area =
        width * width * cosine * cosine * cosine * incident.distance * incident.distance;
    return incident.irradiance * area;
  }

  int side_;
  std::vector<Patch> patches_;
  std::vector<double> sums_ = {0.0};      // of mean flux, patch by patch
  std::vector<double> row_sums_ = {0.0};  // row by row
};

}  // namespace

SceneSphere sphere_around(const Scene& scene) {
  // A little wider, so that what touches the sphere is on the maps.
  return {0.5f * (scene.bounds_min + scene.bounds_max), 1.001f * scene.bounding_radius()};
}

std::vector<MappedLight> mapped_lights(std::span<const Light> lights, const SceneSphere& sphere) {
  std::vector<MappedLight> mapped;
  for (const Light& light : lights) {
    mapped.push_back({.light = punctual_light(light), .projection = projection_of(light, sphere)});
  }
  return mapped;
}

std::vector<MappedLight> environment_lights(const Environment& environment, int count,
                                            std::uint64_t seed, const SceneSphere& sphere) {
  const EnvironmentSampler sampler(environment);
  std::vector<MappedLight> lights;
  if (sampler.black()) return lights;
  PointSequence points(seed, 0, 0, purpose_environment);
  for (int i = 0; i < count; ++i) {
    const auto [u, v] = points.next();
    const EnvironmentSampler::Sample sample = sampler.sample(u, v);
    const glm::vec3 travel = -sample.direction_world;
    lights.push_back(
        {.light = {glm::vec4(0, 0, 0, float(light_directional)), glm::vec4(travel, 0.0f),
                   glm::vec4(sample.radiance / (float(count) * sample.pdf), 0.0f)},
         .projection = parallel_projection(travel, sphere.center_world, sphere.radius)});
  }
  return lights;
}

std::vector<MappedLight> virtual_lights(std::span<const MappedLight> lights, int count, int side,
                                        std::uint64_t seed, const Scene& scene,
                                        const GpuScene& gpu_scene, ProgramCache& programs) {
  Patches patches(side);
  for (const MappedLight& light : lights) patches.add(light, scene, gpu_scene, programs);
  std::vector<MappedLight> virtual_ones;
  if (!(patches.total() > 0.0)) return virtual_ones;
  const float lift = nearest_share * sphere_around(scene).radius;
  PointSequence points(seed, 0, 0, purpose_virtual);
  for (int i = 0; i < count; ++i) {
    const auto [u, v] = points.next();
    const Patch& patch = patches.draw(u, v);
    const auto scale = float(patches.total() / (Patches::mean(patch.flux) * double(count)));
    const glm::vec3 position = patch.position_world + lift * patch.normal_world;
    virtual_ones.push_back(
        {.light = {glm::vec4(position, float(light_point)), glm::vec4(patch.normal_world, 0.0f),
                   glm::vec4(patch.flux * (scale / pi), 0.0f)},
         .is_virtual = true,
         .projection = half_space_projection(position, patch.normal_world, lift)});
  }
  return virtual_ones;
}

}  // namespace occlab
