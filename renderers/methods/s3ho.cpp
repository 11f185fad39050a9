#include "renderers/methods/representation_layers.h"
#include "renderers/methods/screen_space.h"

namespace occlab {

MethodInfo s3ho() {
  const ScreenSpacePasses passes{
      .occlusion_shader = "renderers/methods/s3ho.frag",
      .lighting_shader = "renderers/methods/s3ho_lighting.frag",
      .representation_formats = {GL_RGBA32UI, GL_RGBA32UI},
      .off_screen_shader = {},
      .read_layers =
          [](const Framebuffer& packed, Layers& layers) {
            Image coefficients = unpack_sh(packed.colors()[0], packed.colors()[1]);
            layers.add("ambient_occlusion", sh_ambient_occlusion(coefficients));
            layers.add("sh_visibility", std::move(coefficients));
          },
  };
  return {.name = "s3ho",
          .title = "S3HO",
          .paper = "Herholz, Schairer, Schilling, Strasser 2012",
          .parameters = screen_space_parameters(),
          .layers = {"ambient_occlusion", "sh_visibility"},
          .shaders = screen_space_shaders({passes.occlusion_shader, passes.lighting_shader}),
          .make = [passes] { return std::make_unique<ScreenSpaceMethod>(passes); }};
}

}  // namespace occlab
