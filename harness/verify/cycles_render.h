#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "renderers/scene/environment.h"
#include "renderers/scene/view.h"

namespace occlab {

/// What Blender is asked to render with scenes/cycles.py.
struct CyclesJob {
  std::filesystem::path scene;
  View view;
  const Environment& environment;
  float rotation_degrees = 0.0f;  ///< of the environment, ProbeSettings::rotation_degrees
  double ao_distance_world = 1.0;
  long samples_per_seed = 128;
  int seeds = 8;
  std::filesystem::path blender;  ///< find_blender()
};

/// Images of independent seeds, and the wall time of making all of them.
struct SeededRendering {
  std::vector<Image> images;
  double seconds = 0.0;          ///< of rendering alone, all images together
  double prepare_seconds = 0.0;  ///< of what one image needs before: the BVH and so on
};

struct CyclesRendering {
  std::string version;
  SeededRendering light;  ///< radiance, RGB
  SeededRendering ao;     ///< k_A, 1 channel
};

/// Runs Blender once. `folder` is an existing folder for the job and its images. Throws InputError
/// where scenes/cycles.py refuses the scene and DeviceError where Blender fails, with its last
/// words (all of them are in cycles.log there), or an image is missing, of another size or not
/// finite.
CyclesRendering render_with_cycles(const CyclesJob& job, const std::filesystem::path& folder);

}  // namespace occlab
