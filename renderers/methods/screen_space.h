#pragma once

#include <functional>
#include <optional>
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
};

/// Occlusion pass (or rays on the CPU), then the bilateral filter of the representation, then
/// deferred lighting.
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
  void run_filter(const Frame& frame, const ParameterSet& parameters);
  void run_lighting(const Frame& frame, const ParameterSet& parameters,
                    const Framebuffer& representation);

  ScreenSpacePasses passes_;
  std::optional<Framebuffer> representation_;
  std::optional<Framebuffer> filtered_;
  std::optional<Framebuffer> radiance_;
};

/// Completes a method's description from its passes.
MethodInfo screen_space_method(MethodInfo info, ScreenSpacePasses passes);

}  // namespace occlab
