#pragma once

#include <memory>
#include <optional>
#include <string>

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

/// A loaded scene on a device, ready for the methods.
class Workbench {
 public:
  /// Throws InputError where the scene, the view or the probe is not to be had or there is no light
  /// at all, DeviceError where the device is not.
  Workbench(const ViewSettings& settings, const std::string& device);

  Frame& frame() { return *frame_; }
  const Frame& frame() const { return *frame_; }
  const Scene& scene() const { return scene_; }
  const DeviceInfo& device() const { return context_.info(); }
  /// The probe that lights the view: as asked for, or the scene's own; source "" if there is none.
  const ProbeSettings& probe() const { return probe_; }
  /// SHA-256 of the scene's and the probe's file; "none" without a probe.
  const std::string& scene_hash() const { return scene_hash_; }
  const std::string& probe_hash() const { return probe_hash_; }

 private:
  Context context_;
  ProgramCache programs_;
  Scene scene_;
  ProbeSettings probe_;
  std::string scene_hash_;
  std::string probe_hash_;
  std::optional<GpuScene> gpu_scene_;
  std::optional<Frame> frame_;
};

/// "cathedral, filtered 3 deg, +1 stops, turned 90 deg": how tables name the light.
std::string describe(const ProbeSettings& probe);

}  // namespace occlab
