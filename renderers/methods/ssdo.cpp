#include "renderers/methods/ssdo.h"

#include "renderers/methods/representation_layers.h"
#include "renderers/methods/screen_space.h"
#include "renderers/shared/representation_radiance.h"

namespace occlab {
namespace {

using Values = Representation::Values;

glm::vec3 rgb(const Values& values) { return {values[0], values[1], values[2]}; }

void set_rgb(Values& values, glm::vec3 value) {
  for (int c = 0; c < 3; ++c) values[std::size_t(c)] = value[c];
}

constexpr Representation incoming_light = {
    .channels = 3,
    .reads_radiance = true,
    .accumulate =
        [](Values& sums, const SampledDirection& s) {
          glm::vec3 sum = rgb(sums);
          radiance_accumulate(sum, s.visibility, s.radiance, s.cosine);
          set_rgb(sums, sum);
        },
    .result = [](Values& sums, int count) { set_rgb(sums, radiance_irradiance(rgb(sums), count)); },
    .irradiance = [](const Values& E, const ShadedPoint&, const CpuLighting&) { return rgb(E); },
    .upload = upload_floats,
    .download = download_floats,
    .add_layers = [](const Image& E, Layers& layers) { layers.add("irradiance", E); },
};

}  // namespace

const Representation& ssdo_representation() { return incoming_light; }

MethodInfo ssdo() {
  const ScreenSpacePasses passes{
      .occlusion_shader = "renderers/methods/ssdo.frag",
      .lighting_shader = "renderers/methods/ssdo_lighting.frag",
      .representation_formats = {GL_RGBA32F},
      .representation = &ssdo_representation(),
      .off_screen_shader = {},
  };
  return screen_space_method({.name = "ssdo",
                              .title = "SSDO",
                              .paper = "Ritschel, Grosch, Seidel 2009",
                              .parameters = screen_space_parameters(),
                              .layers = {"irradiance"}},
                             passes);
}

}  // namespace occlab
