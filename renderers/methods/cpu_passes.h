#pragma once

#include <span>

#include "renderers/methods/frame.h"
#include "renderers/methods/parameters.h"
#include "renderers/methods/representation.h"
#include "renderers/methods/visibility_source.h"

namespace occlab {

// The passes of the screen-space methods on the CPU: what the shaders compute, from the headers
// they include, over the same G-buffer and samples; and the same with rays for the march. An image
// of a representation has Representation::channels channels, 0 where no surface is seen.

/// What an occlusion pass reads.
struct DirectionPass {
  const GBufferImages& surface;
  const CpuLighting& lighting;
  const PassConstants& constants;
  VisibilitySource visibility;
};

/// A sample set, and the sums that its directions are added to: images of the representations'
/// channels, in their order.
struct DirectionSums {
  const SampleSet& samples;
  std::span<Image> sums;
};

/// Adds every direction of the sets at every pixel to the sums of each representation. The pixels'
/// frames are those of the first set; another set is turned against it as a whole, by what their
/// first turns differ by: so what a tile's rays can meet is listed once. Multi-threaded; throws
/// Interrupted.
void add_directions(const DirectionPass& pass, std::span<const DirectionSums> sets,
                    TurnPattern pattern, std::span<const Representation* const> representations);
void add_directions(const DirectionPass& pass, const SampleSet& samples, TurnPattern pattern,
                    std::span<const Representation* const> representations, std::span<Image> sums);

/// Sums over `count` directions as the occlusion pass writes them.
Image representation_of(const Representation& representation, const Image& sums, int count);

/// bilateral.frag.
Image filter_on_cpu(const Image& values, const GBufferImages& surface,
                    const PassConstants& constants);

/// L_o = rho E / pi, RGB, not clamped.
Image light_on_cpu(const Representation& representation, const Image& values,
                   const GBufferImages& surface, const CpuLighting& lighting);

/// What a method's passes hold before its lighting.
struct PassValues {
  Image representation;  ///< with the bounce, where that is added to it
  Image direct;          ///< the representation without it; empty where it is not added
  Image bounce;          ///< where it is kept apart; empty otherwise
};

/// The unfiltered values with the parameters' samples, seed and visibility source.
PassValues collect_on_cpu(const Frame& frame, const ParameterSet& parameters,
                          const Representation& representation);
/// Each of them filtered.
PassValues filter_on_cpu(const PassValues& values, const GBufferImages& surface,
                         const PassConstants& constants);
/// L_o of all light, RGB, not clamped.
Image light_on_cpu(const Representation& representation, const PassValues& values,
                   const GBufferImages& surface, const CpuLighting& lighting);

/// The bounce's part of it, where the representation has one.
Image light_bounce_on_cpu(const Representation& representation, const PassValues& values,
                          const GBufferImages& surface, const CpuLighting& lighting);

/// All passes: the layers that the method's evaluate() gives, but for `off_screen`.
Layers evaluate_on_cpu(const Frame& frame, const ParameterSet& parameters,
                       const Representation& representation);

/// The whole occlusion pass with the parameters' samples, seed and visibility source.
Image occlusion_on_cpu(const Frame& frame, const ParameterSet& parameters,
                       const Representation& representation);

}  // namespace occlab
