#include "renderers/scene/scene.h"

#include <fmt/format.h>

#include <algorithm>

#include "renderers/scene/error.h"

namespace occlab {

std::size_t Scene::triangle_count() const {
  std::size_t count = 0;
  for (const Instance& instance : instances) {
    count += meshes[std::size_t(instance.mesh)].indices.size() / 3;
  }
  return count;
}

const Camera& find_camera(const Scene& scene, const std::string& name) {
  if (name.empty() && !scene.cameras.empty()) return scene.cameras.front();
  const auto camera = std::ranges::find(scene.cameras, name, &Camera::name);
  if (camera != scene.cameras.end()) return *camera;
  std::vector<std::string> names;
  for (const Camera& candidate : scene.cameras) names.push_back(candidate.name);
  throw InputError(
      fmt::format("{}: no camera '{}'{}", scene.path.string(), name, accepted_words(name, names)));
}

}  // namespace occlab
