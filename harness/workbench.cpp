#include "harness/workbench.h"

#include <fmt/format.h>

#include <cmath>

#include "harness/files.h"
#include "renderers/scene/data_root.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

/// The probe that the scene's extras name (scenes/FORMAT.md).
ProbeSettings scene_probe(const Scene& scene) {
  if (!scene.environment) return {};
  const SceneEnvironment& environment = *scene.environment;
  ProbeSettings probe;
  const std::filesystem::path beside = scene.path.parent_path() / environment.probe;
  probe.source = std::filesystem::exists(beside) ? beside.string() : environment.probe;
  probe.rotation_degrees = environment.rotation_degrees;
  probe.exposure_stops = std::log2(environment.strength);
  return probe;
}

Environment load_light(const Scene& scene, const ProbeSettings& probe) {
  if (!probe.source.empty()) return load_environment(probe);
  if (scene.lights.empty()) {
    throw InputError(
        fmt::format("{}: nothing lights the scene: it has no lights and no world "
                    "environment, and no probe was named",
                    scene.path.string()));
  }
  return constant_environment(glm::vec3(0.0f));
}

std::string hash_probe(const ProbeSettings& probe) {
  if (probe.source.empty()) return "none";
  for (const ProbeName& known : probe_names()) {
    if (known.name == probe.source) return sha256_file(known.path);
  }
  return sha256_file(probe.source);
}

}  // namespace

Workbench::Workbench(const ViewSettings& settings, const std::string& device)
    : context_(device),
      scene_(load_scene(scene_path(settings.scene))),
      probe_(settings.probe ? *settings.probe : scene_probe(scene_)),
      scene_hash_(sha256_file(scene_.path)) {
  const View view{find_camera(scene_, settings.view), settings.width, settings.height};
  Lighting lighting(load_light(scene_, probe_), scene_.lights, view);
  probe_hash_ = hash_probe(probe_);  // after load_light, which says what is wrong with the name
  gpu_scene_.emplace(scene_);
  frame_.emplace(Frame{.scene = scene_,
                       .gpu_scene = *gpu_scene_,
                       .view = view,
                       .lighting = std::move(lighting),
                       .programs = programs_});
}

std::string describe(const ProbeSettings& probe) {
  if (probe.source.empty()) return "none";
  std::string text = std::filesystem::path(probe.source).stem().string();
  if (probe.prefilter_degrees != 0.0f)
    text += fmt::format(", filtered {:g} deg", probe.prefilter_degrees);
  if (probe.exposure_stops != 0.0f) text += fmt::format(", {:+g} stops", probe.exposure_stops);
  if (probe.rotation_degrees != 0.0f)
    text += fmt::format(", turned {:g} deg", probe.rotation_degrees);
  return text;
}

}  // namespace occlab
