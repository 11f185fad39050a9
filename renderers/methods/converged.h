#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "renderers/methods/cpu_passes.h"

namespace occlab {

/// When enough directions have been added up.
struct Convergence {
  /// RMS standard error of the radiance over the surface's pixels, in mean luminances, that every
  /// method must reach.
  double tolerance = 0.01;
  double budget_seconds = 60.0;    ///< no further round begins after this
  int first_round = 64;            ///< directions; every round has twice as many as the last
  std::uint64_t seed = 1'000'000;  ///< of the first round's sample set; no run's own seeds
};

/// A method with a visibility source, at so many directions that sampling no longer shows. The
/// march keeps its S steps and their random offsets.
struct Converged {
  Image radiance;               ///< L_o, RGB, clamped at 0; no filter
  double standard_error = 0.0;  ///< as Convergence::tolerance measures it
  int directions = 0;           ///< a pixel
  bool reached = false;         ///< the tolerance
};

/// A method's representation and the parameters its lighting reads.
struct ConvergedMethod {
  const Representation* representation;
  PassConstants constants;
};

/// Methods that share their visibility (all constants but the lighting's are those of the first)
/// share its directions too. The standard error is that of two halves of the rounds, whose radiance
/// differs by it on average: so it holds for representations that light does not read linearly.
std::vector<Converged> converge(const GBufferImages& surface, const Lighting& lighting,
                                const VisibilitySource& visibility,
                                const std::vector<ConvergedMethod>& methods,
                                const Convergence& convergence);

}  // namespace occlab
