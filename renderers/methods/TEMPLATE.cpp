// Copy to NAME.cpp, replace NAME, and add METHOD(NAME) to the list in registry.cpp. TEMPLATE.* are
// not built.
#include "renderers/methods/representation_layers.h"
#include "renderers/methods/screen_space.h"

namespace occlab {

MethodInfo NAME() {
  const ScreenSpacePasses passes{
      // Writes the representation, one layout(location = i) output for each format below.
      .occlusion_shader = "renderers/methods/NAME.frag",
      // Turns the representation into radiance; those of the four methods can be used again.
      .lighting_shader = "renderers/methods/ssao_lighting.frag",
      .representation_formats = {GL_R32F},
      // The same on the CPU, as ssao.cpp has it: needed for traced visibility and error budgets.
      .on_cpu = nullptr,
      .off_screen_shader = {},
      // What the method shows beside its radiance.
      .read_layers =
          [](const Framebuffer& representation, Layers& layers) {
            layers.add("ambient_occlusion",
                       channels_of(representation.colors()[0].download(), 0, 1));
          },
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
