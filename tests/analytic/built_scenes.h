// Scenes of few shapes whose occlusion has a closed form, built in code.
#pragma once

#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <numbers>

#include "renderers/scene/environment.h"
#include "renderers/scene/scene.h"
#include "renderers/shared/equirect.h"

namespace occlab::test {

inline constexpr double pi_d = std::numbers::pi;

/// A parallelogram; its normal is u x v.
inline Mesh quad(glm::vec3 corner, glm::vec3 u, glm::vec3 v) {
  Mesh mesh;
  mesh.name = "quad";
  mesh.positions = {corner, corner + u, corner + u + v, corner + v};
  mesh.normals.assign(4, glm::normalize(glm::cross(u, v)));
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return mesh;
}

/// A surface of revolution about +Z through `profile(t)` = (radius, height), t in [0, 1], its
/// vertices on the surface. Normals are those of the chords, which only the G-buffer would use.
inline Mesh revolution(const std::function<glm::dvec2(double)>& profile, int rings, int segments) {
  Mesh mesh;
  mesh.name = "revolution";
  for (int i = 0; i <= rings; ++i) {
    const glm::dvec2 at = profile(double(i) / rings);
    for (int j = 0; j < segments; ++j) {
      const double phi = 2.0 * pi_d * j / segments;
      mesh.positions.emplace_back(at.x * std::cos(phi), at.x * std::sin(phi), at.y);
      mesh.normals.emplace_back(std::cos(phi), std::sin(phi), 0.0);
    }
  }
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < segments; ++j) {
      const auto a = std::uint32_t(i * segments + j);
      const auto b = std::uint32_t(i * segments + (j + 1) % segments);
      const auto above = std::uint32_t(segments);
      for (const std::uint32_t v : {a, b, b + above, a, b + above, a + above}) {
        mesh.indices.push_back(v);
      }
    }
  }
  return mesh;
}

/// The part of a sphere between two polar angles from +Z, `rings` rings high.
inline Mesh sphere_part(glm::dvec3 centre, double radius, double first, double last, int rings) {
  Mesh mesh = revolution(
      [=](double t) {
        const double theta = first + t * (last - first);
        return glm::dvec2(radius * std::sin(theta), radius * std::cos(theta));
      },
      rings, 2 * rings);
  for (glm::vec3& p : mesh.positions) p += glm::vec3(centre);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.normals[i] = glm::normalize(mesh.positions[i] - glm::vec3(centre));
  }
  return mesh;
}

/// The distance from the centre of the facets of a whole sphere_part(), as a share of the radius:
/// at least this, at most 1.
inline double sphere_facet_distance(int rings) {
  const double half_step = std::cos(0.5 * pi_d / rings);
  return half_step * half_step;
}

/// Collects meshes, one instance each unless told otherwise, and finds the bounds.
class SceneBuilder {
 public:
  SceneBuilder() {
    scene_.name = "built";
    scene_.materials.push_back({.name = "white", .albedo = glm::vec3(1.0f), .albedo_texture = {}});
  }
  SceneBuilder& add(Mesh mesh, const glm::mat4& world_from_object = glm::mat4(1.0f)) {
    scene_.meshes.push_back(std::move(mesh));
    return instance(int(scene_.meshes.size()) - 1, world_from_object);
  }
  /// Closed, counter-clockwise from outside.
  SceneBuilder& add_box(glm::vec3 low, glm::vec3 high) {
    const glm::vec3 size = high - low;
    const glm::vec3 x(size.x, 0, 0), y(0, size.y, 0), z(0, 0, size.z);
    add(quad(low, z, y)).add(quad(low + x, y, z));
    add(quad(low, x, z)).add(quad(low + y, z, x));
    return add(quad(low, y, x)).add(quad(low + z, x, y));
  }
  SceneBuilder& instance(int mesh, const glm::mat4& world_from_object) {
    scene_.instances.push_back({mesh, world_from_object});
    return *this;
  }
  SceneBuilder& material(glm::vec3 albedo) {
    scene_.materials.push_back({.name = "next", .albedo = albedo, .albedo_texture = {}});
    scene_.meshes.back().material = int(scene_.materials.size()) - 1;
    return *this;
  }
  Scene build() {
    scene_.bounds_min = glm::vec3(1e30f);
    scene_.bounds_max = glm::vec3(-1e30f);
    for (const Instance& placed : scene_.instances) {
      for (const glm::vec3& p : scene_.meshes[std::size_t(placed.mesh)].positions) {
        const glm::vec3 world(placed.world_from_object * glm::vec4(p, 1.0f));
        scene_.bounds_min = glm::min(scene_.bounds_min, world);
        scene_.bounds_max = glm::max(scene_.bounds_max, world);
      }
    }
    return scene_;
  }

 private:
  Scene scene_;
};

/// An equirect probe whose texels hold `radiance` of their centres' directions.
inline Environment probe_of(int width, const std::function<glm::vec3(glm::vec3)>& radiance) {
  Environment environment;
  environment.name = "built";
  environment.texels = Image(width, width / 2, 3);
  for (int y = 0; y < width / 2; ++y) {
    for (int x = 0; x < width; ++x) {
      const glm::vec2 uv((float(x) + 0.5f) / float(width), (float(y) + 0.5f) / float(width / 2));
      const glm::vec3 value = radiance(equirect_direction(uv));
      for (int c = 0; c < 3; ++c) environment.texels.at(x, y, c) = value[c];
    }
  }
  return environment;
}

/// Midpoint rule over [low, high].
inline double integrate(double low, double high, const std::function<double(double)>& f,
                        int steps = 20000) {
  double sum = 0.0;
  for (int i = 0; i < steps; ++i) sum += f(low + (high - low) * (i + 0.5) / steps);
  return sum * (high - low) / steps;
}

}  // namespace occlab::test
