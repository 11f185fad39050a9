#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "renderers/scene/environment.h"
#include "renderers/scene/view.h"
#include "renderers/trace/traced_scene.h"

namespace occlab {

/// How directions are drawn. All three estimate the same integral.
enum class Estimator { mis, cosine, environment };

/// What the surfaces that rays meet send: the direct light that reaches them within d_max, with its
/// shadows, or all of it, as if nothing blocked it.
enum class SentLight { shaded, unoccluded };

/// One bounce of light: surfaces that block send light themselves.
struct TracedBounce {
  SentLight sent = SentLight::shaded;
  const Scene* scene = nullptr;  ///< whose surfaces these are; outlives the tracing
};

struct TraceSettings {
  long rays_per_pixel = 1024;  ///< rounded up to a whole number of rays for each of the batches
  Estimator estimator = Estimator::mis;
  std::uint64_t seed = 0;
  float d_max_world =
      std::numeric_limits<float>::infinity();  ///< blockers farther away do not count
  int weight = 0;                              ///< shared/visibility.h
  float lambda_per_world = 1.0f;
  float fade_start = 0.75f;
  std::optional<TracedBounce> bounce = std::nullopt;  ///< none: direct light alone
};

/// The surface points to shade: those of a G-buffer, view space, 3 channels; `mask` is 1 where a
/// surface is seen.
struct SurfacePoints {
  const Image& position_view;
  const Image& normal_view;
  const Image& geometric_normal_view;
  const Image& albedo;
  const Image& mask;
};

/// Ray-traced directional occlusion. Pixels without a surface are 0.
struct Reference {
  Image radiance;           ///< L_o, RGB
  Image radiance_variance;  ///< of the mean, RGB, from independent batches
  Image radiance_indirect;  ///< the bounce's part of L_o, RGB; empty without one
  Image ambient_occlusion;  ///< k_A; empty with the environment estimator, which cannot tell
  long rays_per_pixel = 0;  ///< as traced, light rays and those of a bounce not counted
  std::uint64_t rays = 0;   ///< all rays of the image
};

/// L(p) = (rho/pi) int L_in(w) v(p, w) (n.w) dw + the punctual lights, where v is 1 if nothing is
/// hit within d_max and the weight of the hit's distance otherwise. Rays start 1e-5 bounding radii
/// above the surface along the geometric normal.
///
/// With a bounce, + (rho/pi) int (1 - v(p, w)) L_o(hit) (n.w) dw: of cosine-distributed directions,
/// as many as there are rays of either strategy, each of which that meets something samples the
/// light there once by the cosine and once by the probe.
///
/// A tile of 4x4 pixels shares its random numbers, each pixel turning them into its own tangent
/// frame, so that 16 rays travel together. Each pixel's estimate and variance are those of
/// independent samples; errors of pixels within a tile are correlated.
Reference trace_reference(const TracedScene& traced, const Environment& environment,
                          std::span<const Light> lights, const View& view,
                          const SurfacePoints& points, const TraceSettings& settings);

/// Batches that give the variance of the mean.
inline constexpr long reference_batches = 16;

}  // namespace occlab
