#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renderers/gl/context.h"
#include "renderers/methods/frame.h"

namespace occlab {

/// What a view is rendered from: names as the command line and the experiment file give them.
struct ViewSettings {
  std::string scene;  ///< a scene's name, or a path
  std::string view;   ///< a camera's name; empty: the first
  int width = 1280;
  int height = 720;
  std::optional<ProbeSettings> probe;  ///< none: the scene's own environment
};

/// A scene's file, read.
struct LoadedScene {
  std::string source;  ///< as it was asked for
  Scene scene;
  std::string hash;  ///< SHA-256 of the file
};
LoadedScene load(const std::string& source);

/// The probe that lights the scene: as asked for, or the scene's own; source "" if there is none.
ProbeSettings probe_of(const ViewSettings& settings, const Scene& scene);
/// SHA-256 of the probe's file; "none" without a probe.
std::string hash_probe(const ProbeSettings& probe);

/// What workbenches that are there one after the other have in common: the graphics context, the
/// compiled programs, and what the last ones loaded and made, as far as the next one needs the
/// same. One scene is kept, and probes up to 256 MB.
class Equipment {
 public:
  /// Throws as Context does.
  explicit Equipment(const std::string& device) : context_(device) {}

  const DeviceInfo& device() const { return context_.info(); }
  /// The scene that was loaded last, if it is this one; else this one is loaded in its place. No
  /// workbench may be using another.
  const LoadedScene& scene(const std::string& source) { return scene_in_use(source)->loaded; }
  /// The probe, loaded and prefiltered, and the hash of its file.
  struct LoadedProbe {
    ProbeSettings settings;
    Environment environment;
    std::string hash;
  };
  const LoadedProbe& probe(const ProbeSettings& settings);

 private:
  friend class Workbench;
  struct SceneInUse {
    LoadedScene loaded;
    std::optional<GpuScene> gpu;
  };
  /// What a frame has made, and of what.
  struct MadeFrame {
    std::string view;
    int width = 0;
    int height = 0;
    Frame::Made made;
  };
  std::shared_ptr<SceneInUse> scene_in_use(const std::string& source);

  Context context_;
  ProgramCache programs_;
  std::shared_ptr<SceneInUse> scene_;
  std::optional<MadeFrame> made_;  ///< of scene_
  std::vector<LoadedProbe> probes_;
};

/// A loaded scene on a device, ready for the methods.
class Workbench {
 public:
  /// Throws InputError where the scene, the view or the probe is not to be had or there is no light
  /// at all, DeviceError where the device is not.
  Workbench(const ViewSettings& settings, const std::string& device)
      : Workbench(settings, std::make_shared<Equipment>(device)) {}
  /// On equipment that no other workbench is using.
  Workbench(const ViewSettings& settings, std::shared_ptr<Equipment> equipment);
  ~Workbench();
  Workbench(Workbench&&) noexcept = default;
  Workbench& operator=(Workbench&&) = delete;
  Workbench(const Workbench&) = delete;
  Workbench& operator=(const Workbench&) = delete;

  Frame& frame() { return *frame_; }
  const Frame& frame() const { return *frame_; }
  const Scene& scene() const { return scene_->loaded.scene; }
  const DeviceInfo& device() const { return equipment_->device(); }
  /// The probe that lights the view: as asked for, or the scene's own; source "" if there is none.
  const ProbeSettings& probe() const { return probe_; }
  /// SHA-256 of the scene's and the probe's file; "none" without a probe.
  const std::string& scene_hash() const { return scene_->loaded.hash; }
  const std::string& probe_hash() const { return probe_hash_; }
  /// What is to be said of the scene, its lights seen from the view, and the probe; a sentence
  /// each.
  std::vector<std::string> warnings() const;

 private:
  std::shared_ptr<Equipment> equipment_;
  std::shared_ptr<Equipment::SceneInUse> scene_;
  ProbeSettings probe_;
  std::string probe_hash_;
  std::unique_ptr<Frame> frame_;
};

/// "cathedral, filtered 3 deg, +1 stops, turned 90 deg": how tables name the light.
std::string describe(const ProbeSettings& probe);

}  // namespace occlab
