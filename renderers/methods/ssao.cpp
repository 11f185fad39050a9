#include "renderers/methods/representation_layers.h"
#include "renderers/methods/screen_space.h"

namespace occlab {

MethodInfo ssao() {
  const ScreenSpacePasses passes{
      .occlusion_shader = "renderers/methods/ssao.frag",
      .lighting_shader = "renderers/methods/ssao_lighting.frag",
      .representation_formats = {GL_R32F},
      .off_screen_shader = "renderers/methods/off_screen.frag",
      .read_layers =
          [](const Framebuffer& k_A, Layers& layers) {
            layers.add("ambient_occlusion", channels_of(k_A.colors()[0].download(), 0, 1));
          },
  };
  return {.name = "ssao",
          .title = "SSAO",
          .paper = "Mittring 2007; Shanmugam and Arikan 2007",
          .parameters = screen_space_parameters(),
          .layers = {"ambient_occlusion", "off_screen"},
          .shaders = screen_space_shaders(
              {passes.occlusion_shader, passes.lighting_shader, passes.off_screen_shader}),
          .make = [passes] { return std::make_unique<ScreenSpaceMethod>(passes); }};
}

}  // namespace occlab
