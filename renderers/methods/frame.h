#pragma once

#include <array>
#include <functional>
#include <list>
#include <optional>
#include <string_view>

#include "renderers/gl/gbuffer.h"
#include "renderers/gl/hidden_surfaces.h"
#include "renderers/methods/lighting.h"
#include "renderers/trace/traced_scene.h"

namespace occlab {

/// Runs one pass of a method; a timer wraps it, everyone else just calls it.
using PassClock = std::function<void(std::string_view pass, const std::function<void()>& run)>;

/// One view of a scene under one light, as every method gets it. G-buffers, the ray tracer's scene
/// and the lighting are made when first asked for and shared from then on.
struct Frame {
  const Scene& scene;
  const GpuScene& gpu_scene;
  View view;
  Lighting lighting;
  ProgramCache& programs;
  PassClock clock = [](std::string_view, const std::function<void()>& run) { run(); };

  const GBuffer& gbuffer(GBufferBits bits) const;
  /// A G-buffer read back.
  const GBufferImages& surface(GBufferBits bits = GBufferBits::float32) const;
  const TracedScene& traced() const;
  /// Surfaces beside the first, drawn. Good until `most_hidden` others were asked for.
  const HiddenSurfaces& hidden(const HiddenSettings& settings) const;
  /// The same read back.
  const HiddenImages& hidden_images(const HiddenSettings& settings) const;

  static constexpr std::size_t most_hidden = 4;
  struct MadeHidden {
    HiddenSurfaces surfaces;
    std::optional<HiddenImages> images;
  };
  struct Made {
    std::array<std::optional<GBuffer>, 2> gbuffers;
    std::array<std::optional<GBufferImages>, 2> surfaces;
    std::optional<TracedScene> traced;
    std::list<MadeHidden> hidden = {};  ///< what was asked for last first
  };
  mutable Made made{};
};

}  // namespace occlab
