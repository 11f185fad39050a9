#include "harness/workbench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "harness/files.h"
#include "renderers/scene/confined_path.h"
#include "renderers/scene/data_root.h"
#include "renderers/scene/enclosed_lights.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

/// The probe that the scene's extras name (scenes/FORMAT.md).
ProbeSettings scene_probe(const Scene& scene) {
  if (!scene.environment) return {};
  const SceneEnvironment& environment = *scene.environment;
  ProbeSettings probe;
  probe.source = environment.probe;
  if (is_path(environment.probe)) {
    const std::string where = scene.path.string() + ": extras.occlab.world.probe";
    probe.source = confined_path(scene.path.parent_path(), environment.probe, where).string();
  }
  probe.rotation_degrees = environment.rotation_degrees;
  probe.exposure_stops = std::log2(environment.strength);
  return probe;
}

constexpr std::size_t most_probe_bytes = std::size_t(256) << 20;

std::size_t bytes_of(const Environment& environment) {
  return environment.texels.values().size_bytes();
}

}  // namespace

LoadedScene load(const std::string& source) {
  LoadedScene loaded{source, load_scene(scene_path(source)), ""};
  loaded.hash = sha256_file(loaded.scene.path);
  return loaded;
}

ProbeSettings probe_of(const ViewSettings& settings, const Scene& scene) {
  return settings.probe ? *settings.probe : scene_probe(scene);
}

std::string hash_probe(const ProbeSettings& probe) {
  if (probe.source.empty()) return "none";
  for (const ProbeName& known : probe_names()) {
    if (known.name == probe.source) return sha256_file(known.path);
  }
  return sha256_file(probe.source);
}

std::shared_ptr<Equipment::SceneInUse> Equipment::scene_in_use(const std::string& source) {
  if (scene_ && scene_->loaded.source == source) return scene_;
  // Two scenes are never in memory at once.
  made_.reset();
  scene_.reset();
  scene_ = std::make_shared<SceneInUse>(SceneInUse{load(source), std::nullopt});
  return scene_;
}

const Equipment::LoadedProbe& Equipment::probe(const ProbeSettings& settings) {
  const auto known = std::ranges::find_if(probes_, [&](const LoadedProbe& probe) {
    return probe.settings.source == settings.source &&
           probe.settings.rotation_degrees == settings.rotation_degrees &&
           probe.settings.exposure_stops == settings.exposure_stops &&
           probe.settings.prefilter_degrees == settings.prefilter_degrees;
  });
  if (known != probes_.end()) return *known;
  LoadedProbe loaded{settings, load_environment(settings), ""};
  loaded.hash = hash_probe(settings);  // after loading, which says what is wrong with the name
  std::size_t bytes = bytes_of(loaded.environment);
  for (const LoadedProbe& probe : probes_) bytes += bytes_of(probe.environment);
  while (!probes_.empty() && bytes > most_probe_bytes) {
    bytes -= bytes_of(probes_.front().environment);
    probes_.erase(probes_.begin());
  }
  probes_.push_back(std::move(loaded));
  return probes_.back();
}

Workbench::Workbench(const ViewSettings& settings, std::shared_ptr<Equipment> equipment)
    : equipment_(std::move(equipment)),
      scene_(equipment_->scene_in_use(settings.scene)),
      probe_(probe_of(settings, scene())) {
  const View view{find_camera(scene(), settings.view), settings.width, settings.height};
  if (probe_.source.empty() && scene().lights.empty()) {
    throw InputError(
        fmt::format("{}: nothing lights the scene: it has no lights and no world "
                    "environment, and no probe was named",
                    scene().path.string()));
  }
  const bool dark = probe_.source.empty();
  Lighting lighting(
      dark ? constant_environment(glm::vec3(0.0f)) : equipment_->probe(probe_).environment,
      scene().lights, view);
  probe_hash_ = dark ? hash_probe(probe_) : equipment_->probe(probe_).hash;
  if (!scene_->gpu) scene_->gpu.emplace(scene());
  frame_ = std::make_unique<Frame>(Frame{.scene = scene(),
                                         .gpu_scene = *scene_->gpu,
                                         .view = view,
                                         .lighting = std::move(lighting),
                                         .programs = equipment_->programs_});
  if (auto made = std::exchange(equipment_->made_, std::nullopt)) {
    frame_->made.traced = std::move(made->made.traced);
    if (made->view == view.camera.name && made->width == view.width &&
        made->height == view.height) {
      frame_->made = Frame::Made{std::move(made->made.gbuffers), std::move(made->made.surfaces),
                                 std::move(frame_->made.traced)};
    }
  }
}

Workbench::~Workbench() {
  if (!frame_) return;  // moved from
  const View& view = frame_->view;
  equipment_->made_.emplace(
      Equipment::MadeFrame{view.camera.name, view.width, view.height, std::move(frame_->made)});
}

std::vector<std::string> Workbench::warnings() const {
  std::vector<std::string> warnings = scene().warnings;
  const glm::vec3 eye_world(frame_->view.camera.world_from_camera[3]);
  for (const auto& [light, mesh] : enclosed_lights(scene(), eye_world)) {
    warnings.push_back(
        fmt::format("light '{}' is inside of mesh '{}', where the camera '{}' is not: it lights "
                    "nothing but that inside, which methods in screen space may miss",
                    light, mesh, frame_->view.camera.name));
  }
  if (probe_.source.empty()) return warnings;
  const Environment& environment = frame_->lighting.environment();
  if (const auto clamped = environment.clamped_negative_texels) {
    warnings.push_back(
        fmt::format("{}: {} slightly negative texels were set to 0", probe_.source, clamped));
  }
  if (std::ranges::all_of(environment.texels.values(), [](float v) { return v == 0.0f; })) {
    warnings.push_back(
        fmt::format("{}: the probe is black: the environment gives no light", probe_.source));
  }
  return warnings;
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
