#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "renderers/methods/converged.h"

namespace occlab {

/// Why the march through the depth buffer and a ray through the scene disagree about a direction.
/// Light that leaks in where the ray is blocked, and light that is lost where it is not.
enum class FailureClass {
  off_screen,      ///< leak: the blocker is off the screen or behind the camera
  hidden_blocker,  ///< leak: the blocker is behind the first surface of its pixel
  thin,            ///< leak: the blocker is seen through its pixel; the steps missed it
  edge,            ///< either: a pixel's centre and the ray see different sides of a silhouette
  behind_surface,  ///< loss: the ray is free, and passes behind the first surface
  beyond_radius,   ///< loss: what the ray meets is farther than d_max
};
inline constexpr std::array<std::string_view, 6> failure_class_names = {
    "off_screen", "hidden_blocker", "thin", "edge", "behind_surface", "beyond_radius"};

/// What a class adds to the error of the march; positive where light leaks in. The classes add up
/// to the march less the rays over the same directions.
struct FailureMaps {
  Image occlusion;  ///< of k_A, one channel
  Image radiance;   ///< of L_o, RGB, as SSDO looks light up
};

struct Failures {
  std::array<FailureMaps, failure_class_names.size()> classes;
  double standard_error = 0.0;  ///< RMS over the surface, of the sum of all classes' k_A
  int directions = 0;
  bool reached = false;  ///< convergence.tolerance, here in k_A
};

/// Compares both for the directions of one set after another, until the sum over the classes has
/// converged. Punctual lights are left out. With `hidden`, complete ones, the march is through them
/// too: what only a layer or another camera shows is on the screen, and not hidden.
Failures classify_failures(const GBufferImages& surface, const View& view,
                           const TracedScene& traced, const Lighting& lighting,
                           const PassConstants& constants, const Convergence& convergence,
                           const HiddenImages* hidden = nullptr);

}  // namespace occlab
