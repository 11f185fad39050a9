#include "renderers/methods/representation_layers.h"
#include "renderers/methods/screen_space.h"

namespace occlab {

MethodInfo ssbn() {
  const ScreenSpacePasses passes{
      .occlusion_shader = "renderers/methods/ssbn.frag",
      .lighting_shader = "renderers/methods/ssbn_lighting.frag",
      .representation_formats = {GL_RGBA32F},
      .off_screen_shader = {},
      .read_layers =
          [](const Framebuffer& bent_cone, Layers& layers) {
            const Image bent = bent_cone.colors()[0].download();
            layers.add("uniform_occlusion", channels_of(bent, 3, 1));
            layers.add("bent_normal", channels_of(bent, 0, 3));
          },
  };
  std::vector<Parameter> parameters = screen_space_parameters();
  parameters.push_back(choice_parameter(
      "cone_angle", {"linear", "exact"},
      "half-angle from |N|: the paper's linear form, or cos C = 2|N| - 1, exact for a cap"));
  return {.name = "ssbn",
          .title = "SSBN",
          .paper = "Klehm, Ritschel, Eisemann, Seidel 2011",
          .parameters = std::move(parameters),
          .layers = {"uniform_occlusion", "bent_normal"},
          .shaders = screen_space_shaders({passes.occlusion_shader, passes.lighting_shader}),
          .make = [passes] { return std::make_unique<ScreenSpaceMethod>(passes); }};
}

}  // namespace occlab
