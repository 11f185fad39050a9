#include "renderers/scene/enclosed_lights.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>

namespace occlab {
namespace {

/// What a closed mesh's winding number may be off by: its vertices are rounded.
constexpr double tolerance = 1e-3;

double solid_angle(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
  const double length_a = glm::length(a);
  const double length_b = glm::length(b);
  const double length_c = glm::length(c);
  return 2.0 * std::atan2(glm::dot(a, glm::cross(b, c)),
                          length_a * length_b * length_c + glm::dot(a, b) * length_c +
                              glm::dot(b, c) * length_a + glm::dot(c, a) * length_b);
}

struct Bounds {
  glm::vec3 low{std::numeric_limits<float>::infinity()};
  glm::vec3 high{-std::numeric_limits<float>::infinity()};

  void add(glm::vec3 point) {
    low = glm::min(low, point);
    high = glm::max(high, point);
  }
  bool hold(glm::vec3 point) const {
    return glm::all(glm::lessThanEqual(low, point)) && glm::all(glm::lessThanEqual(point, high));
  }
};

/// The closed things of a scene: a mesh's primitives at one place, neighbours among the instances.
class Enclosures {
 public:
  explicit Enclosures(const Scene& scene) : scene_(scene) {
    for (const Mesh& mesh : scene.meshes) {
      Bounds& bounds = bounds_.emplace_back();
      for (const glm::vec3& position : mesh.positions) bounds.add(position);
    }
    const std::span<const Instance> all = scene.instances;
    for (std::size_t first = 0; first < all.size();) {
      std::size_t count = 1;
      while (first + count < all.size() && together(all[first], all[first + count])) ++count;
      things_.push_back(all.subspan(first, count));
      first += count;
    }
  }

  /// The name of the first that `inside` is inside of and `outside` is not.
  std::optional<std::string> between(glm::vec3 inside, glm::vec3 outside) const {
    const auto found = std::ranges::find_if(things_, [&](std::span<const Instance> thing) {
      return encloses(thing, inside) && !encloses(thing, outside);
    });
    if (found == things_.end()) return std::nullopt;
    return mesh(found->front()).name;
  }

 private:
  const Mesh& mesh(const Instance& instance) const {
    return scene_.meshes[std::size_t(instance.mesh)];
  }

  bool together(const Instance& a, const Instance& b) const {
    return a.world_from_object == b.world_from_object && mesh(a).name == mesh(b).name;
  }

  bool encloses(std::span<const Instance> thing, glm::vec3 point_world) const {
    const glm::dmat4 object_from_world = glm::inverse(glm::dmat4(thing.front().world_from_object));
    const glm::dvec3 point(object_from_world * glm::dvec4(point_world, 1.0));
    Bounds bounds;
    for (const Instance& primitive : thing) {
      if (scene_.materials[std::size_t(mesh(primitive).material)].alpha_cutoff) return false;
      bounds.add(bounds_[std::size_t(primitive.mesh)].low);
      bounds.add(bounds_[std::size_t(primitive.mesh)].high);
    }
    if (!bounds.hold(glm::vec3(point))) return false;
    double windings = 0.0;
    for (const Instance& primitive : thing) windings += winding_number(mesh(primitive), point);
    return std::abs(windings) > 1.0 - tolerance;
  }

  const Scene& scene_;
  std::vector<Bounds> bounds_;  ///< of meshes
  std::vector<std::span<const Instance>> things_;
};

}  // namespace

double winding_number(const Mesh& mesh, glm::dvec3 point_object) {
  const auto corner = [&](std::size_t index) {
    return glm::dvec3(mesh.positions[mesh.indices[index]]) - point_object;
  };
  double sum = 0.0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    sum += solid_angle(corner(i), corner(i + 1), corner(i + 2));
  }
  return sum / (4.0 * std::numbers::pi);
}

std::vector<EnclosedLight> enclosed_lights(const Scene& scene, glm::vec3 eye_world) {
  const Enclosures enclosures(scene);
  std::vector<EnclosedLight> enclosed;
  for (const Light& light : scene.lights) {
    if (light.type == LightType::directional) continue;
    if (auto mesh = enclosures.between(light.position_world, eye_world)) {
      enclosed.push_back({light.name, *std::move(mesh)});
    }
  }
  return enclosed;
}

}  // namespace occlab
