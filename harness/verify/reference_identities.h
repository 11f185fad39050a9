#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "harness/verify/layer_agreement.h"

namespace occlab {

/// The order-4 SH reconstruction of a probe on `width` x `width`/2 texels, plus whatever constant
/// makes each channel non-negative: a light that is its own order-4 reconstruction. Turned as the
/// probe is.
Environment order4_environment(const Environment& probe, int width);

/// How often, and how finely, both sides are rendered with seeds of their own.
struct Replication {
  int replicates = 24;        ///< at least 4
  int directions = 128;       ///< N of a replicate
  long rays_per_pixel = 512;  ///< of the reference, a replicate
  std::uint64_t seed = 1;
};

/// The mean over a region of one layer's channel, by rays into a representation (measured) and by
/// RTDO (expected). The standard error is that of their difference, from the replicates: Student's
/// t with replicates - 1 degrees of freedom, whatever the correlation of pixels.
struct RegionMeans {
  std::string layer;
  int channel = 0;
  std::string region;  ///< "the block at (8, 16)", "the picture"
  double measured = 0.0;
  double expected = 0.0;
  double standard_error = 0.0;
};

struct ReferenceComparison {
  std::vector<RegionMeans> regions;
  /// Means of the replicates; the bounds are the standard errors of each pixel's difference.
  LayerAgreement images;
};

/// Traced visibility in a representation, without filter, against RTDO, under the frame's probe
/// alone; `parameters` (of any screen-space method) give d_max and the weight. Layers:
/// `ssao_ambient_occlusion`, `s3ho_radiance` and `ssdo_radiance`. The first and the last are equal
/// under any probe, S3HO's under order4_environment() only. Regions are blocks of 8x8 pixels with
/// at least 16 that show a surface, and all of the picture. Directions have random heights within
/// their strata, so that both sides are without bias.
ReferenceComparison compare_to_reference(const Frame& frame, const ParameterSet& parameters,
                                         const Replication& replication);

/// The region of a layer whose means differ by most standard errors; one that holds anything but
/// numbers comes first.
const RegionMeans& worst_region(const ReferenceComparison& comparison, const std::string& layer);

/// By how many standard errors any of `tests` regions may differ if all of them together are to
/// raise a false alarm with probability `family_level` (Student's t; Sidak 1967).
double critical_standard_errors(double family_level, int tests, int replicates);

}  // namespace occlab
