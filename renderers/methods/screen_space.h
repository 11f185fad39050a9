#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderers/gl/texture.h"
#include "renderers/methods/method.h"
#include "renderers/methods/pass_constants.h"
#include "renderers/methods/representation.h"

namespace occlab {

/// What tells one screen-space method from another: everything else is shared.
struct ScreenSpacePasses {
  std::string occlusion_shader;
  std::string lighting_shader;
  std::vector<GLenum> representation_formats;  ///< the occlusion pass's targets
  /// GLSL that goes before the occlusion shader. Empty: none.
  std::function<std::string(const ParameterSet&)> occlusion_preamble = {};
  /// What evaluate() has to say of the way it went.
  std::function<void(const ParameterSet&, Metadata&)> add_facts = {};
  /// What the targets hold, and the same on the CPU; outlives the method.
  const Representation* representation = nullptr;
  /// A pass of the same samples that fills one float, drawn for evaluate() only and never timed:
  /// it becomes the layer `off_screen`. Empty: none.
  std::string off_screen_shader;
  /// With a bounce: lights the first of the occlusion pass's targets as if there were none. Drawn
  /// for evaluate() only, which takes the layers `radiance_indirect` and
  /// `radiance_indirect_unfiltered` from it. Empty: direct light alone.
  std::string direct_lighting_shader = {};
  /// A bounce that cannot be collected along with occlusion, as it needs the result: a pass that
  /// reads the occlusion pass's targets and, behind them, the framebuffer lit by these, and writes
  /// such targets with the bounce. Empty: none.
  std::string bounce_shader = {};
};

/// Occlusion pass (or rays on the CPU), then the pass of a bounce, if there is one, then the
/// bilateral filter of the representation, then deferred lighting.
class ScreenSpaceMethod final : public OcclusionMethod {
 public:
  explicit ScreenSpaceMethod(ScreenSpacePasses passes) : passes_(std::move(passes)) {}

  void render(const Frame& frame, const ParameterSet& parameters) override;
  Layers evaluate(const Frame& frame, const ParameterSet& parameters, Metadata& facts) override;

 private:
  void prepare(const Frame& frame);
  void run_samples(const Frame& frame, const ParameterSet& parameters, const std::string& shader,
                   const std::string& preamble, const Framebuffer& target, std::string_view pass);
  void run_occlusion(const Frame& frame, const ParameterSet& parameters);
  void run_bounce(const Frame& frame, const ParameterSet& parameters);
  void light_hidden(const Frame& frame, const ParameterSet& parameters,
                    const HiddenSettings& settings);
  void run_filter(const Frame& frame, const ParameterSet& parameters,
                  const Framebuffer& representation);
  void run_lighting(const Frame& frame, const ParameterSet& parameters, const std::string& shader,
                    const Framebuffer& representation, std::string_view pass = "lighting");
  Image lit(const Frame& frame, const ParameterSet& parameters, const std::string& shader,
            const Framebuffer& representation);
  void add_indirect(const Frame& frame, const ParameterSet& parameters, const Image& radiance,
                    const Image& unfiltered, Layers& layers);
  /// What is filtered.
  const Framebuffer& collected() const { return bounced_ ? *bounced_ : *representation_; }

  ScreenSpacePasses passes_;
  std::optional<Framebuffer> representation_;
  std::optional<Framebuffer> bounced_;  ///< only where a bounce has a pass of its own
  /// The direct light of hidden surfaces, which send it: a layer each.
  struct LitHidden {
    LitHidden(const HiddenSurfaces& hidden, std::span<const GLenum> representation_formats);
    Framebuffer representation;  ///< of one after the other
    Texture radiance;
    std::vector<LayerFramebuffer> targets;  ///< the layers of `radiance`
    bool fits(const HiddenSurfaces& hidden) const;
  };
  std::optional<LitHidden> lit_hidden_;
  std::optional<Framebuffer> filtered_;
  std::optional<Framebuffer> radiance_;
};

/// Completes a method's description from its passes.
MethodInfo screen_space_method(MethodInfo info, ScreenSpacePasses passes);

}  // namespace occlab
