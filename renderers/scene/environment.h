#pragma once

#include <array>
#include <filesystem>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "renderers/scene/image.h"
#include "renderers/shared/sh.h"

namespace occlab {

/// How a light probe is asked for.
struct ProbeSettings {
  std::string source;  ///< a name of probe_names(), or a path of an equirect EXR or HDR
  float rotation_degrees =
      0.0f;  ///< turns the environment about world +Y, counter-clockwise from above
  float exposure_stops = 0.0f;     ///< texels times 2^stops
  float prefilter_degrees = 0.0f;  ///< sigma of the Gaussian exp(-angle^2 / (2 sigma^2)); 0: none
};

/// A distant light: piecewise-constant texels of an equirect image. The same texels and the same
/// nearest look-up serve every method, the SH projection and the ray tracer.
///
/// Row 0 is the top (+Y). Direction of (u, v) in probe space: phi = 2 pi (u - 1/2),
/// el = pi (1/2 - v), d = (cos el cos phi, sin el, cos el sin phi).
struct Environment {
  std::string name;
  Image texels;                             ///< RGB radiance, exposure and prefilter applied
  glm::mat3 probe_from_world{1.0f};         ///< the rotation; orthonormal
  std::size_t clamped_negative_texels = 0;  ///< negative input texels set to 0, to be reported

  /// Radiance from unit direction `d` (away from the shaded point), world space, nearest texel.
  glm::vec3 radiance(glm::vec3 direction_world) const;
};

/// Loads, exposes and prefilters a probe. Throws InputError naming the file and what is wrong
/// (missing, unreadable, zero size, NaN or Inf, not 2:1).
Environment load_environment(const ProbeSettings& settings);

/// A constant environment, for tests and furnaces.
Environment constant_environment(glm::vec3 radiance);

/// Our own probes (scenes/probes) and Blender's studio lights, as far as they are on this machine.
struct ProbeName {
  std::string name;
  std::filesystem::path path;
};
std::vector<ProbeName> probe_names();

/// Order-4 SH of the radiance, in the space given by `world_from_space` (a rotation). Texels are
/// weighted with their exact solid angle (2 pi / W)(cos theta_top - cos theta_bottom).
ShRgb project_sh(const Environment& environment, const glm::mat3& world_from_space);

/// SSBN's pre-convolved lighting [Klehm et al. 2011]: L_c(omega, alpha) = (t/pi) int_cone L cos,
/// t = 1/(1 - cos alpha), at alpha_k = (k+1)/levels * pi/2. Equirect images in *probe space*.
struct ConePrefilter {
  std::vector<Image> levels;
};
ConePrefilter prefilter_cones(const Environment& environment, int levels, int width);

/// Importance sampling of the texels: p(omega) = p(u, v) / (2 pi^2 sin theta), constant in a texel.
class EnvironmentSampler {
 public:
  explicit EnvironmentSampler(const Environment& environment);

  struct Sample {
    glm::vec3 direction_world;
    glm::vec3 radiance;
    float pdf;  ///< per solid angle; > 0
  };
  /// u1, u2 in [0, 1).
  Sample sample(float u1, float u2) const;
  /// Density (1/sr) with which sample() returns this direction; 0 where the probe is black.
  float pdf(glm::vec3 direction_world) const;

 private:
  const Environment* environment_;
  std::vector<float> row_cdf_;     // height + 1
  std::vector<float> column_cdf_;  // height rows of width + 1
};

}  // namespace occlab
