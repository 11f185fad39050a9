#include <algorithm>

#include "renderers/methods/frame.h"
#include "renderers/methods/method.h"
#include "renderers/methods/pass_constants.h"
#include "renderers/trace/reference.h"

namespace occlab {
namespace {

TraceSettings settings_of(const ParameterSet& parameters) {
  const BlockerWeight blocker = blocker_weight(parameters);
  return {.rays_per_pixel = parameters.integer("rays_per_pixel"),
          .estimator = Estimator(choice_index(parameters, "estimator")),
          .seed = std::uint64_t(parameters.integer("seed")),
          .d_max_world = blocker.d_max_world,
          .weight = blocker.weight,
          .lambda_per_world = blocker.lambda_per_world,
          .fade_start = blocker.fade_start};
}

class RayTracedOcclusion final : public OcclusionMethod {
 public:
  void render(const Frame& frame, const ParameterSet& parameters) override {
    const GBufferImages& surface = frame.surface();
    const TracedScene& traced = frame.traced();
    frame.clock("trace", [&] {
      reference_ =
          trace_reference(traced, frame.lighting.environment(), frame.lighting.lights(), frame.view,
                          {surface.position_view, surface.normal_view,
                           surface.geometric_normal_view, surface.albedo, surface.mask},
                          settings_of(parameters));
    });
  }

  Layers evaluate(const Frame& frame, const ParameterSet& parameters, Metadata& facts) override {
    render(frame, parameters);
    Layers layers;
    layers.add("radiance", std::move(reference_.radiance));
    layers.add("radiance_variance", std::move(reference_.radiance_variance));
    if (!reference_.ambient_occlusion.empty()) {
      layers.add("ambient_occlusion", std::move(reference_.ambient_occlusion));
    }
    facts["rays_per_pixel_traced"] = std::to_string(reference_.rays_per_pixel);
    facts["rays"] = std::to_string(reference_.rays);
    return layers;
  }

 private:
  Reference reference_;
};

}  // namespace

MethodInfo rtdo() {
  std::vector<Parameter> parameters = {
      integer_parameter("rays_per_pixel", 1024, 1, 1 << 24, "",
                        "rounded up to a whole number of rays for each of 16 batches"),
      choice_parameter("estimator", {"mis", "cosine", "environment"},
                       "how directions are drawn: balance heuristic of both, in proportion to the "
                       "cosine, or to the probe's texels"),
      seed_parameter("draws the directions"),
      real_parameter("d_max_world", 1.0, 1e-6, std::numeric_limits<double>::infinity(),
                     "scene units", "farthest blocker that counts; inf is accepted"),
  };
  std::ranges::move(weight_parameters(), std::back_inserter(parameters));
  return {.name = "rtdo",
          .title = "RTDO",
          .paper = "ray-traced directional occlusion, the truth of Herholz et al. 2012",
          .parameters = std::move(parameters),
          .layers = {"radiance_variance", "ambient_occlusion"},
          .shaders = {},
          .make = [] { return std::make_unique<RayTracedOcclusion>(); }};
}

}  // namespace occlab
