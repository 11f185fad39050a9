#pragma once

#include <filesystem>
#include <string>

#include "harness/verify/check.h"
#include "harness/workbench.h"

namespace occlab {

/// What RTDO and Blender's Cycles render, each for itself, and how long they may take.
struct CyclesSettings {
  /// Lit by its probe alone: the scene's punctual lights are left out on both sides. The default
  /// is the comparison of the S3HO paper (configs/papers/s3ho.toml) in small, about a minute on two
  /// cores.
  ViewSettings view = {.scene = "gallery",
                       .view = "",
                       .width = 160,
                       .height = 90,
                       .probe = ProbeSettings{.source = "cathedral", .prefilter_degrees = 8.0f}};
  /// Paths (Cycles) a pixel, all seeds together; rounded up to a whole number for each seed.
  long samples = 1024;
  /// Rays (RTDO) a pixel, all seeds together; rounded up to a whole number for each seed.
  long rays_per_pixel = 16384;
  /// Independent renderings a renderer; their spread is its noise. 4 to 64.
  int seeds = 8;
  /// Farthest blocker of the ambient occlusion, in scene units; > 0.
  double ao_distance_world = 0.5;
  std::string device = "auto";
  std::string blender = "blender";  ///< a program on the PATH, or a path
  /// Folder for the images; created. Empty: they are written only when a check fails, into a
  /// folder of the system's temporary directory that the check's detail names.
  std::filesystem::path output;
};

/// Probability of a false alarm of the two shares below.
inline constexpr double cycles_family_level = 2e-6;

/// Renders the view with RTDO at unlimited distance and with Cycles (direct environment light of
/// the same texels, no filter, no clamp), and its ambient occlusion with both, and compares them.
/// Subject "cycles". Pixels near silhouettes are left out. Rows:
///   - the largest relative difference of a 64x64 block's mean, whose 95% interval must lie within
///     0.5%: a block that is too noisy to tell fails and says so;
///   - the share of pixels that differ by more than 3 sigma of the noise of both, against what
///     noise alone gives;
///   - the ratio of the means over the picture;
///   - the ratio of the times for equal error, which is reported and not judged.
/// Throws InputError for settings out of range, a scene that cannot be compared and where there is
/// no such Blender; DeviceError where Blender fails or its image is not what was asked for.
Checks verify_cycles(const CyclesSettings& settings);

}  // namespace occlab
