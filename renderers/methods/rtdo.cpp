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
  explicit RayTracedOcclusion(std::optional<SentLight> bounce) : bounce_(bounce) {}

  void render(const Frame& frame, const ParameterSet& parameters) override {
    const GBufferImages& surface = frame.surface();
    const TracedScene& traced = frame.traced();
    TraceSettings settings = settings_of(parameters);
    if (bounce_) settings.bounce = {.sent = *bounce_, .scene = &frame.scene};
    frame.clock("trace", [&] {
      reference_ =
          trace_reference(traced, frame.lighting.environment(), frame.lighting.lights(), frame.view,
                          {surface.position_view, surface.normal_view,
                           surface.geometric_normal_view, surface.albedo, surface.mask},
                          settings);
    });
  }

  Layers evaluate(const Frame& frame, const ParameterSet& parameters, Metadata& facts) override {
    render(frame, parameters);
    Layers layers;
    layers.add("radiance", std::move(reference_.radiance));
    layers.add("radiance_variance", std::move(reference_.radiance_variance));
    if (bounce_) layers.add("radiance_indirect", std::move(reference_.radiance_indirect));
    if (!reference_.ambient_occlusion.empty()) {
      layers.add("ambient_occlusion", std::move(reference_.ambient_occlusion));
    }
    facts["rays_per_pixel_traced"] = std::to_string(reference_.rays_per_pixel);
    facts["rays"] = std::to_string(reference_.rays);
    return layers;
  }

 private:
  std::optional<SentLight> bounce_;
  Reference reference_;
};

MethodInfo traced_method(std::string name, std::string title, std::string paper,
                         std::optional<SentLight> bounce) {
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
  std::vector<std::string> layers = {"radiance_variance", "ambient_occlusion"};
  if (bounce) layers.emplace_back("radiance_indirect");
  return {.name = name,
          .title = std::move(title),
          .paper = std::move(paper),
          .parameters = std::move(parameters),
          .layers = std::move(layers),
          .shaders = {},
          .make = [bounce] { return std::make_unique<RayTracedOcclusion>(bounce); },
          .truth = name};
}

}  // namespace

MethodInfo rtdo() {
  return traced_method("rtdo", "RTDO",
                       "ray-traced directional occlusion, the truth of Herholz et al. 2012", {});
}

MethodInfo rtgi_unoccluded() {
  return traced_method("rtgi_unoccluded", "RTGI, unoccluded senders",
                       "RTDO and one bounce, of light that nothing blocks on its way to the "
                       "sender: the truth of S3HOGI [Herholz et al. 2012, section 2.3]",
                       SentLight::unoccluded);
}

MethodInfo rtgi_shaded() {
  return traced_method("rtgi_shaded", "RTGI, shaded senders",
                       "RTDO and one bounce of what RTDO shows of the sender: the truth of SSDO's "
                       "indirect light [Ritschel et al. 2009, section 3]",
                       SentLight::shaded);
}

}  // namespace occlab
