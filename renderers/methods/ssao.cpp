#include "renderers/methods/representation_layers.h"
#include "renderers/methods/screen_space.h"
#include "renderers/shared/representation_ao.h"

namespace occlab {
namespace {

using Values = Representation::Values;

glm::vec3 irradiance(const Values& k_A, const ShadedPoint& point, const CpuLighting& lighting) {
  glm::vec3 E = lighting.unoccluded_irradiance(point.normal);
  for (const PunctualLight& light : lighting.lights()) {
    const IncidentLight incident = incident_light(light, point.position);
    E += incident.irradiance * std::max(dot(point.normal, incident.direction), 0.0f);
  }
  return ao_irradiance(k_A[0], E);
}

constexpr Representation ambient_occlusion = {
    .channels = 1,
    .accumulate = [](Values& sums,
                     const SampledDirection& s) { ao_accumulate(sums[0], s.visibility, s.cosine); },
    .result = [](Values& sums, int count) { sums[0] = ao_result(sums[0], count); },
    .irradiance = irradiance,
    .upload = upload_floats,
    .download = download_floats,
    .add_layers = [](const Image& k_A, Layers& layers) { layers.add("ambient_occlusion", k_A); },
};

}  // namespace

MethodInfo ssao() {
  const ScreenSpacePasses passes{
      .occlusion_shader = "renderers/methods/ssao.frag",
      .lighting_shader = "renderers/methods/ssao_lighting.frag",
      .representation_formats = {GL_R32F},
      .representation = &ambient_occlusion,
      .off_screen_shader = "renderers/methods/off_screen.frag",
  };
  return screen_space_method({.name = "ssao",
                              .title = "SSAO",
                              .paper = "Mittring 2007; Shanmugam and Arikan 2007",
                              .parameters = screen_space_parameters(),
                              .layers = {"ambient_occlusion", "off_screen"}},
                             passes);
}

}  // namespace occlab
