#include "renderers/methods/representation_layers.h"
#include "renderers/methods/screen_space.h"
#include "renderers/shared/representation_bent_cone.h"

namespace occlab {
namespace {

using Values = Representation::Values;

glm::vec4 rgba(const Values& values) { return {values[0], values[1], values[2], values[3]}; }

void set_rgba(Values& values, glm::vec4 value) {
  for (int c = 0; c < 4; ++c) values[std::size_t(c)] = value[c];
}

glm::vec3 irradiance(const Values& bent_cone, const ShadedPoint& point,
                     const CpuLighting& lighting) {
  const glm::vec3 bent(rgba(bent_cone));
  const float bent_length = length(bent);
  if (bent_length == 0.0f) return glm::vec3(0.0f);
  const glm::vec3 N = bent / bent_length;
  const float angle = bent_cone_angle(bent_length, lighting.cone_angle());
  glm::vec3 L = lighting.cone_radiance(N, angle);
  for (const PunctualLight& light : lighting.lights()) {
    const IncidentLight incident = incident_light(light, point.position);
    L += bent_cone_delta_light(incident.irradiance, dot(N, incident.direction), angle);
  }
  return bent_cone_irradiance(bent_cone[3], L, dot(N, point.normal));
}

constexpr Representation bent_cone = {
    .channels = 4,
    .accumulate =
        [](Values& sums, const SampledDirection& s) {
          glm::vec4 sum = rgba(sums);
          bent_cone_accumulate(sum, s.visibility, s.direction);
          set_rgba(sums, sum);
        },
    .turn =
        [](Values& sums, const glm::mat3& frame) {
          const glm::vec4 sum = rgba(sums);
          set_rgba(sums, glm::vec4(frame * glm::vec3(sum), sum.w));
        },
    .result = [](Values& sums, int count) { set_rgba(sums, bent_cone_result(rgba(sums), count)); },
    .irradiance = irradiance,
    .upload = upload_floats,
    .download = download_floats,
    .add_layers =
        [](const Image& bent, Layers& layers) {
          layers.add("uniform_occlusion", channels_of(bent, 3, 1));
          layers.add("bent_normal", channels_of(bent, 0, 3));
        },
};

}  // namespace

MethodInfo ssbn() {
  const ScreenSpacePasses passes{
      .occlusion_shader = "renderers/methods/ssbn.frag",
      .lighting_shader = "renderers/methods/ssbn_lighting.frag",
      .representation_formats = {GL_RGBA32F},
      .representation = &bent_cone,
      .off_screen_shader = {},
  };
  std::vector<Parameter> parameters = screen_space_parameters();
  parameters.push_back(choice_parameter(
      "cone_angle", {"linear", "exact"},
      "half-angle from |N|: the paper's linear form, or cos C = 2|N| - 1, exact for a cap"));
  parameters.back().factor = Factor::lighting;
  return screen_space_method({.name = "ssbn",
                              .title = "SSBN",
                              .paper = "Klehm, Ritschel, Eisemann, Seidel 2011",
                              .parameters = std::move(parameters),
                              .layers = {"uniform_occlusion", "bent_normal"}},
                             passes);
}

}  // namespace occlab
