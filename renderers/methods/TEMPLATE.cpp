// Copy to NAME.cpp, replace NAME, and add METHOD(NAME) to the list in registry.cpp. TEMPLATE.* are
// not built.
#include "renderers/methods/representation_layers.h"
#include "renderers/methods/screen_space.h"

namespace occlab {
namespace {

// The representation once more for the CPU, which traced visibility and the error budget need. What
// NAME.frag and its lighting pass compute; formulas that both have go into renderers/shared.
constexpr Representation representation = {
    .channels = 1,
    .accumulate = [](Representation::Values& sums,
                     const SampledDirection& s) { sums[0] += s.visibility * s.cosine; },
    .result = [](Representation::Values& sums, int count) { sums[0] *= 2.0f / float(count); },
    .irradiance =
        [](const Representation::Values& k_A, const ShadedPoint& point,
           const CpuLighting& lighting) {
          return k_A[0] * lighting.unoccluded_irradiance(point.normal);
        },
    .upload = upload_floats,
    .download = download_floats,
    // What the method shows beside its radiance.
    .add_layers = [](const Image& k_A, Layers& layers) { layers.add("ambient_occlusion", k_A); },
};

}  // namespace

MethodInfo NAME() {
  const ScreenSpacePasses passes{
      // Writes the representation, one layout(location = i) output for each format below.
      .occlusion_shader = "renderers/methods/NAME.frag",
      // Turns the representation into radiance; those of the four methods can be used again.
      .lighting_shader = "renderers/methods/ssao_lighting.frag",
      .representation_formats = {GL_R32F},
      .representation = &representation,
      .off_screen_shader = {},
  };
  // A parameter declared here is a key of the configuration and of --set, an axis of sweeps, and
  // in the shaders a `uniform float` (real) or a PARAMETER_name constant (integer, choice).
  std::vector<Parameter> parameters = screen_space_parameters();
  parameters.push_back(
      real_parameter("strength", 1.0, 0.0, 10.0, "", "what it does [paper eq. n]"));
  return screen_space_method({.name = "NAME",
                              .title = "NAME",
                              .paper = "authors and year",
                              .parameters = std::move(parameters),
                              .layers = {"ambient_occlusion"}},
                             passes);
}

}  // namespace occlab
