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
  /// A name of probe_names(), or a path (it has a '/' or an extension) of an equirect EXR or HDR.
  std::string source;
  /// Turns the environment about world +Y, counter-clockwise from above.
  float rotation_degrees = 0.0f;
  float exposure_stops = 0.0f;     ///< texels times 2^stops
  float prefilter_degrees = 0.0f;  ///< sigma of prefilter_gaussian, 0 to 180; 0: none
};

/// A distant light: piecewise-constant texels of an equirect image. The same texels and the same
/// nearest look-up serve every method, the SH projection and the ray tracer.
///
/// Row 0 is the top (+Y). Direction of (u, v) in probe space: phi = 2 pi (u - 1/2),
/// el = pi (1/2 - v), d = (cos el cos phi, sin el, cos el sin phi).
struct Environment {
  std::string name;
  Image texels;                             ///< RGB radiance, exposure and prefilter applied
  float blur_degrees = 0.0f;                ///< sigma of the prefilter that was applied; 0: none
  glm::mat3 probe_from_world{1.0f};         ///< the rotation; orthonormal
  std::size_t clamped_negative_texels = 0;  ///< negative input texels set to 0, to be reported

  /// Column and row of the texel that a unit direction (away from the shaded point) falls into.
  glm::ivec2 texel(glm::vec3 direction_world) const;
  /// Radiance from a unit direction (away from the shaded point): the nearest texel.
  glm::vec3 radiance(glm::vec3 direction_world) const;
};

/// Loads, exposes and prefilters a probe. Negative values of at least -0.01 (Blender's studio
/// lights have some, from lossy compression) become 0 and are counted. Throws InputError naming the
/// file and what is wrong: missing, unreadable, zero size, not 2:1, NaN or Inf, a more negative
/// value, a setting out of range.
Environment load_environment(const ProbeSettings& settings);

/// A constant environment, for tests and furnaces.
Environment constant_environment(glm::vec3 radiance);

/// Our own probes (scenes/probes) and Blender's studio lights, as far as they are on this machine.
struct ProbeName {
  std::string name;
  std::filesystem::path path;
};
/// Names are sorted, ours first; a name of ours hides Blender's. The studio lights are looked for
/// in studiolights/world of: $OCCLAB_BLENDER_DATAFILES and nowhere else if it is set; else
/// $BLENDER_SYSTEM_DATAFILES, /usr/share/blender/datafiles, /usr/share/blender/*/datafiles, of
/// which the first that has any counts.
std::vector<ProbeName> probe_names();

/// Convolves an equirect radiance image with the Gaussian exp(-angle^2 / (2 sigma^2)) on the
/// sphere, cut at 5 sigma. Where texels are finer than sigma/4, the image is first averaged to
/// max(32, ceil(4 pi / sigma)) rows, and the result has that size (twice as many columns); else the
/// size is kept. The weights are scaled so that both a constant and the energy (the sum of
/// radiance times solid angle) are preserved.
Image prefilter_gaussian(const Image& texels, float sigma_degrees);

/// The same radiance on `width` x `width`/2 texels, width even: every texel is the solid-angle
/// weighted mean of what it covers, so energy is preserved exactly.
Image resample_area(const Image& texels, int width);

/// Solid angle (sr) of a texel in `row`: (2 pi / W)(cos theta_top - cos theta_bottom).
double texel_solid_angle(const Image& texels, int row);

/// Order-4 SH of the radiance, in the space given by `world_from_space` (a rotation). Each texel
/// contributes its radiance times the integral of the basis over it (2x2 Gauss-Legendre points, its
/// solid angle exact), not a sample at its centre: coarse probes project as well as fine ones.
ShRgb project_sh(const Environment& environment, const glm::mat3& world_from_space);

/// SSBN's pre-convolved lighting [Klehm et al. 2011]: L_c(omega, alpha) = (t/pi) int_cone L cos,
/// t = 1/(1 - cos alpha), at alpha_k = (k+1)/levels * pi/2. Equirect images in *probe space*, of
/// `width` x `width`/2 (width even, at least 16) texels; the probe is averaged to that size first.
/// The cone's edge is a ramp one texel wide, and each level and row is normalised against its own
/// cone: a constant L gives (1 + cos alpha) L.
struct ConePrefilter {
  std::vector<Image> levels;
};
ConePrefilter prefilter_cones(const Environment& environment, int levels, int width);

/// Importance sampling of the texels, by the mean of their RGB times solid angle. Within a texel,
/// phi and cos theta are uniform, so the density is constant per solid angle there: exactly
/// pdf = P(texel) / solid angle(texel), the same for sample() and pdf().
class EnvironmentSampler {
 public:
  /// `environment` must outlive the sampler.
  explicit EnvironmentSampler(const Environment& environment);

  struct Sample {
    glm::vec3 direction_world;
    glm::vec3 radiance;  ///< Environment::radiance(direction_world)
    float pdf;           ///< pdf(direction_world), per solid angle; > 0
  };
  /// u1, u2 in [0, 1). The probe must not be black().
  Sample sample(float u1, float u2) const;
  /// Density (1/sr) with which sample() returns this direction; 0 where the probe is black.
  float pdf(glm::vec3 direction_world) const;
  /// Whether every texel is 0, so that there is nothing to sample.
  bool black() const { return !(row_cdf_.back() > 0.0); }

 private:
  float texel_pdf(glm::ivec2 texel) const;

  const Environment* environment_;
  // Running sums, not normalised. Double: beside a sun of 30000 a float would lose the dark texels.
  std::vector<double> row_cdf_;     // height + 1
  std::vector<double> column_cdf_;  // height rows of width + 1
  std::vector<double> row_cosine_;  // height + 1: of the polar angle at the rows' edges
};

}  // namespace occlab
