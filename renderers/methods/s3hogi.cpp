#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <vector>

#include "renderers/methods/bounce.h"
#include "renderers/methods/representation_layers.h"
#include "renderers/methods/s3ho.h"
#include "renderers/shared/bounce.h"
#include "renderers/shared/representation_sh_bounce.h"

namespace occlab {
namespace {

using Values = Bounce::Values;

constexpr const char* keep_bounce = "keep_bounce";

ShBounce coefficients_of(const Values& v) {
  ShBounce c;
  c.r0 = vec4(v[0], v[1], v[2], v[3]);
  c.r1 = vec4(v[4], v[5], v[6], v[7]);
  c.g0 = vec4(v[9], v[10], v[11], v[12]);
  c.g1 = vec4(v[13], v[14], v[15], v[16]);
  c.b0 = vec4(v[18], v[19], v[20], v[21]);
  c.b1 = vec4(v[22], v[23], v[24], v[25]);
  c.last = vec3(v[8], v[17], v[26]);
  return c;
}

/// Nine coefficients of red, then of green and of blue.
Values values_of(const ShBounce& c) {
  Values v;
  const std::array<std::array<vec4, 2>, 3> colours = {{{c.r0, c.r1}, {c.g0, c.g1}, {c.b0, c.b1}}};
  for (std::size_t colour = 0; colour < 3; ++colour) {
    for (std::size_t i = 0; i < 8; ++i) v[9 * colour + i] = colours[colour][i / 4][int(i % 4)];
    v[9 * colour + 8] = c.last[int(colour)];
  }
  return v;
}

glm::vec3 irradiance(const Values& values, const ShadedPoint& point, const CpuLighting& lighting) {
  const ShBounce c = coefficients_of(values);
  glm::vec3 E = sh_bounce_irradiance(lighting.sh(), c);
  for (const PunctualLight& light : lighting.lights()) {
    const IncidentLight incident = incident_light(light, point.position);
    const Sh4 lobe = sh_scale_bands(sh_basis(incident.direction), lighting.window());
    E += incident.irradiance * sh_bounce_dot(lobe, c);
  }
  return E;
}

void upload(const Image& values, const Framebuffer& target) {
  std::array<std::vector<uvec4>, 4> texels;
  for (std::size_t p = 0; p < values.pixel_count(); ++p) {
    Values pixel;
    std::copy_n(&values.values()[p * pixel.size()], pixel.size(), pixel.begin());
    const ShBounce c = coefficients_of(pixel);
    texels[0].push_back(sh_bounce_pack_colour(c.r0, c.r1));
    texels[1].push_back(sh_bounce_pack_colour(c.g0, c.g1));
    texels[2].push_back(sh_bounce_pack_colour(c.b0, c.b1));
    texels[3].push_back(sh_bounce_pack_last(c.last));
  }
  for (std::size_t i = 0; i < texels.size(); ++i) {
    target.colors()[2 + i].upload_integers(&texels[i][0][0]);
  }
}

uvec4 texel(const std::vector<std::uint32_t>& values, std::size_t index) {
  const std::uint32_t* v = &values[index * 4];
  return uvec4(v[0], v[1], v[2], v[3]);
}

/// `sh_bounce`: nine coefficients of red, then of green and of blue.
void add_coefficients(const Framebuffer& target, const ParameterSet& parameters, Layers& layers) {
  if (parameters.choice(keep_bounce) == "no") return;
  std::array<std::vector<std::uint32_t>, 4> bits;
  for (std::size_t i = 0; i < bits.size(); ++i) {
    bits[i] = target.colors()[2 + i].download_integers();
  }
  const Texture& red = target.colors()[2];
  Image coefficients(red.width(), red.height(), Bounce::most_channels);
  for (std::size_t p = 0; p < coefficients.pixel_count(); ++p) {
    const Values v = values_of(sh_bounce_unpack(texel(bits[0], p), texel(bits[1], p),
                                                texel(bits[2], p), texel(bits[3], p)));
    std::ranges::copy(v, &coefficients.values()[p * v.size()]);
  }
  layers.add("sh_bounce", std::move(coefficients));
}

constexpr Bounce sh_bounce = {
    .channels = 27,
    .storage_error = 0x1p-11f,
    .accumulate =
        [](Values& sums, const Sender& sender, float factor) {
          ShBounce sum = coefficients_of(sums);
          sh_bounce_accumulate(sum, sender.normal, factor / pi * sender.albedo);
          sums = values_of(sum);
        },
    .irradiance = irradiance,
    .result = [](Values& sums) { sums = values_of(sh_bounce_storable(coefficients_of(sums))); },
    .upload = upload,
    .add_layers = add_coefficients,
};

const Representation& representation() {
  static const Representation with_bounce = [] {
    Representation made = s3ho_representation();
    made.bounce = &sh_bounce;
    return made;
  }();
  return with_bounce;
}

}  // namespace

MethodInfo s3hogi() {
  std::vector<Parameter> parameters = s3ho_parameters();
  std::ranges::move(bounce_parameters("solid_angle"), std::back_inserter(parameters));
  std::ranges::move(
      of_factor(Factor::representation,
                {choice_parameter(keep_bounce, {"no", "yes"},
                                  "whether c[SSGI] is also a layer, sh_bounce: three vectors of "
                                  "nine coefficients [S3HO eq. 5]; large")}),
      std::back_inserter(parameters));
  const ScreenSpacePasses passes{
      .occlusion_shader = "renderers/methods/s3hogi.frag",
      .lighting_shader = "renderers/methods/s3hogi_lighting.frag",
      .representation_formats = std::vector<GLenum>(6, GL_RGBA32UI),
      .occlusion_preamble = s3ho_preamble,
      .add_facts = add_s3ho_facts,
      .representation = &representation(),
      .off_screen_shader = {},
      .direct_lighting_shader = "renderers/methods/s3ho_lighting.frag",
  };
  return screen_space_method({.name = "s3hogi",
                              .title = "S3HOGI",
                              .paper = "Herholz, Schairer, Schilling, Strasser 2012, section 2.3",
                              .parameters = std::move(parameters),
                              .layers = {"ambient_occlusion", "sh_visibility", "radiance_indirect",
                                         "radiance_indirect_unfiltered"},
                              .truth = "rtgi_unoccluded"},
                             passes);
}

}  // namespace occlab
