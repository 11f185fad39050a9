#include "renderers/methods/s3ho.h"

#include "renderers/methods/representation_layers.h"
#include "renderers/methods/sample_shader.h"
#include "renderers/shared/representation_sh4.h"
#include "renderers/shared/sh_rotation.h"

namespace occlab {
namespace {

using Values = Representation::Values;

glm::vec3 irradiance(const Values& c, const ShadedPoint& point, const CpuLighting& lighting) {
  glm::vec3 E = sh4_irradiance(lighting.sh(), sh_of(c));
  for (const PunctualLight& light : lighting.lights()) {
    const IncidentLight incident = incident_light(light, point.position);
    const Sh4 lobe = sh_scale_bands(sh_basis(incident.direction), lighting.window());
    E += incident.irradiance * sh_dot(lobe, sh_of(c));
  }
  return E;
}

constexpr Representation visibility_sh = {
    .channels = 16,
    .storage_error = 0x1p-11f,
    .accumulate =
        [](Values& sums, const SampledDirection& s) {
          Sh4 sum = sh_of(sums);
          sh4_accumulate(sum, s.visibility, s.direction, s.cosine);
          sums = values_of(sum);
        },
    .turn = [](Values& sums,
               const glm::mat3& frame) { sums = values_of(sh_rotate(sh_of(sums), frame)); },
    .result = [](Values& sums, int count) { sums = values_of(sh4_result(sh_of(sums), count)); },
    .irradiance = irradiance,
    .upload = upload_packed_sh,
    .download = download_packed_sh,
    .add_layers =
        [](const Image& coefficients, Layers& layers) {
          layers.add("ambient_occlusion", sh_ambient_occlusion(coefficients));
          layers.add("sh_visibility", coefficients);
        },
};

/// Weighted visibility is no bit.
bool projects_bits(const ParameterSet& parameters) {
  return parameters.choice("projection") == "auto" && parameters.choice("weight") == "binary";
}

Parameter projection_parameter() {
  Parameter projection = choice_parameter(
      "projection", {"auto", "direct"},
      "how visible directions become SH: all at once from their bits, where visibility is binary, "
      "or each with its own basis functions, as the paper has it; the result is the same");
  projection.factor = Factor::samples;
  projection.in_shaders = false;
  return projection;
}

}  // namespace

const Representation& s3ho_representation() { return visibility_sh; }

std::vector<Parameter> s3ho_parameters() {
  std::vector<Parameter> parameters = screen_space_parameters();
  parameters.push_back(projection_parameter());
  return parameters;
}

std::string s3ho_preamble(const ParameterSet& parameters) {
  if (!projects_bits(parameters)) return {};
  return "#define PROJECTS_BITS\n" + sh_projection(int(parameters.integer("samples")));
}

void add_s3ho_facts(const ParameterSet& parameters, Metadata& facts) {
  facts["projection"] = projects_bits(parameters) ? "visibility bits" : "direct";
}

MethodInfo s3ho() {
  const ScreenSpacePasses passes{
      .occlusion_shader = "renderers/methods/s3ho.frag",
      .lighting_shader = "renderers/methods/s3ho_lighting.frag",
      .representation_formats = {GL_RGBA32UI, GL_RGBA32UI},
      .occlusion_preamble = s3ho_preamble,
      .add_facts = add_s3ho_facts,
      .representation = &s3ho_representation(),
      .off_screen_shader = {},
  };
  return screen_space_method({.name = "s3ho",
                              .title = "S3HO",
                              .paper = "Herholz, Schairer, Schilling, Strasser 2012",
                              .parameters = s3ho_parameters(),
                              .layers = {"ambient_occlusion", "sh_visibility"}},
                             passes);
}

}  // namespace occlab
