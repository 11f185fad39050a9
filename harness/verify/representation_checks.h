#pragma once

#include <filesystem>
#include <string>

#include "harness/verify/check.h"

namespace occlab {

/// All statistical comparisons of one run raise a false alarm with this probability (Sidak 1967).
inline constexpr double representation_family_level = 1e-6;

struct RepresentationSettings {
  std::string device = "auto";
  /// Where a check that fails leaves measured.exr, expected.exr, difference.exr and bound.exr, in a
  /// folder of its own. Made only when needed.
  std::filesystem::path output;
};

/// Every method with a representation, on every scene that comes with occlab. Subject
/// "representations". Rows:
///   - for each camera and method, GPU against CPU (gpu_and_cpu()) with every weight, a 16-bit
///     G-buffer, the exact cone and both form factors, under the probe sky_sun and the scene's
///     lights: the value that uses most of its bound, as a share of it;
///   - for each of representation_identities(), the same, the worst of all cameras and of both
///     visibility sources;
///   - for each scene, compare_to_reference(): the region that comes closest to its bound.
/// Throws DeviceError without a device.
Checks verify_representations(const RepresentationSettings& settings);

}  // namespace occlab
