#pragma once

#include <span>

#include "renderers/methods/bounce.h"
#include "renderers/methods/frame.h"
#include "renderers/methods/parameters.h"

namespace occlab {

// One bounce on the CPU, as methods/cpu_passes.h has the rest: what the shaders compute, over the
// same G-buffer and samples, and the same with rays for the march.

/// What blockers send, as the passes write it: Bounce::channels channels, 0 where no surface is
/// seen. `lit`: radiance of the direct light, unfiltered, RGB, of the first surfaces and of each
/// layer or camera; read where Bounce::reads_lit. Multi-threaded; throws Interrupted.
Image bounce_on_cpu(const Frame& frame, const ParameterSet& parameters, const Bounce& bounce,
                    std::span<const Image> lit);

/// Its part of L_o, RGB, not clamped.
Image light_bounce_on_cpu(const Bounce& bounce, const Image& values, const GBufferImages& surface,
                          const CpuLighting& lighting);

}  // namespace occlab
