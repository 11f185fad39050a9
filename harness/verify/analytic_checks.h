#pragma once

#include <filesystem>
#include <string>

#include "harness/verify/check.h"

namespace occlab {

/// All statistical comparisons of one subject raise a false alarm with this probability (Sidak
/// 1967): chance alone fails one run in a million.
inline constexpr double analytic_family_level = 1e-6;

struct AnalyticSettings {
  /// A scene file that carries its expected values, or a folder of them; empty: scenes/analytic.
  std::filesystem::path cases;
  /// Where a case that fails leaves its images, in a folder CASE-METHOD/ of its own: image.exr
  /// (the mean over the seeds), expected.exr, error.exr and p_value.exr. Made only when needed.
  std::filesystem::path output;
  std::string device = "auto";
};

// A check for each case and method: the channel, or block, that comes closest to its bound or
// exceeds it. Throws InputError for a bad scene file, DeviceError without a device.

/// The ray tracer's cases. Subject "reference".
Checks verify_reference(const AnalyticSettings& settings);

/// The cases of all other methods. Subject "passes".
Checks verify_passes(const AnalyticSettings& settings);

}  // namespace occlab
