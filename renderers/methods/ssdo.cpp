#include "renderers/methods/representation_layers.h"
#include "renderers/methods/screen_space.h"

namespace occlab {

MethodInfo ssdo() {
  const ScreenSpacePasses passes{
      .occlusion_shader = "renderers/methods/ssdo.frag",
      .lighting_shader = "renderers/methods/ssdo_lighting.frag",
      .representation_formats = {GL_RGBA32F},
      .off_screen_shader = {},
      .read_layers =
          [](const Framebuffer& irradiance, Layers& layers) {
            layers.add("irradiance", channels_of(irradiance.colors()[0].download(), 0, 3));
          },
  };
  return {.name = "ssdo",
          .title = "SSDO",
          .paper = "Ritschel, Grosch, Seidel 2009",
          .parameters = screen_space_parameters(),
          .layers = {"irradiance"},
          .shaders = screen_space_shaders({passes.occlusion_shader, passes.lighting_shader}),
          .make = [passes] { return std::make_unique<ScreenSpaceMethod>(passes); }};
}

}  // namespace occlab
