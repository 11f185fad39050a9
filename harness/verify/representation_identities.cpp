#include "harness/verify/representation_identities.h"

#include <array>
#include <cmath>
#include <numbers>

#include "renderers/methods/cpu_passes.h"
#include "renderers/methods/representation_layers.h"
#include "renderers/shared/sh.h"

namespace occlab {
namespace {

constexpr double half_last_place = 0x1p-24;
constexpr int coefficients = 16;
/// As packed_radiance.h holds it, to the bit.
const glm::vec3 constant_radiance(0.6875f, 1.0f, 2.3125f);

/// Coefficients of the light at a point, and the sums of their parts' magnitudes.
struct LightAtPoint {
  std::array<glm::dvec3, coefficients> value{};
  std::array<glm::dvec3, coefficients> magnitude{};

  void add(std::size_t i, glm::dvec3 part) {
    value[i] += part;
    magnitude[i] += glm::abs(part);
  }
};

LightAtPoint light_at(const CpuLighting& lighting, glm::vec3 position) {
  LightAtPoint light;
  const ShRgb& probe = lighting.sh();
  const auto r = values_of(probe.r);
  const auto g = values_of(probe.g);
  const auto b = values_of(probe.b);
  for (std::size_t i = 0; i < coefficients; ++i) light.add(i, {r[i], g[i], b[i]});
  for (const PunctualLight& lamp : lighting.lights()) {
    const IncidentLight incident = incident_light(lamp, position);
    const auto lobe = values_of(sh_scale_bands(sh_basis(incident.direction), lighting.window()));
    for (std::size_t i = 0; i < coefficients; ++i) {
      light.add(i, glm::dvec3(incident.irradiance) * double(lobe[i]));
    }
  }
  return light;
}

/// A pixel's sums over the directions.
struct DirectSums {
  glm::dvec3 light{0.0};      ///< V L4(s) (n.s)
  glm::dvec3 magnitude{0.0};  ///< V (n.s) sum_i |L_i y_i(s)|
  glm::dvec3 direction{0.0};  ///< V s
  double visible = 0.0;       ///< V

  void add(const LightAtPoint& incoming, glm::vec3 s, double visibility, double cosine) {
    const auto basis = values_of(sh_basis(s));
    for (std::size_t i = 0; i < coefficients; ++i) {
      const double y = double(basis[i]);
      light += visibility * cosine * y * incoming.value[i];
      magnitude += visibility * cosine * std::abs(y) * incoming.magnitude[i];
    }
    direction += visibility * glm::dvec3(s);
    visible += visibility;
  }
};

VisibilitySource visibility_of(const Frame& frame, const ParameterSet& parameters,
                               const GBufferImages& surface, const PassConstants& constants) {
  return traces(parameters) ? traced_visibility(frame.traced(), frame.view, constants)
                            : depth_visibility(surface, frame.view, constants);
}

/// The images of one frame that all identities share.
// NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding): members stand in the order of making
class Identities {
 public:
  Identities(const Frame& frame, const ParameterSet& parameters, const PassConstants& constants,
             const CpuLighting& lighting)
      : frame_(frame),
        parameters_(parameters),
        constants_(constants),
        surface_(frame.surface(gbuffer_bits(parameters))),
        lighting_(lighting),
        visibility_(visibility_of(frame, parameters, surface_, constants_)),
        samples_(make_sample_set(constants_.samples, std::uint64_t(parameters.integer("seed")))) {}

  LayerAgreement all() const {
    LayerAgreement agreement;
    const Image sh = values("s3ho");
    const Image occlusion = values("ssao");
    add_direct_sums(agreement, sh);
    const double rounding = (2.0 * constants_.samples + 16.0) * half_last_place;
    add(agreement, "s3ho_ambient_occlusion", sh_ambient_occlusion(sh), occlusion,
        scaled(occlusion, rounding));
    add_constant_probe(agreement, occlusion, rounding);
    return agreement;
  }

 private:
  static const Representation& representation(const char* method) {
    return *find_method(method).representation;
  }
  Image values(const char* method) const {
    return occlusion_on_cpu(frame_, parameters_, representation(method));
  }
  Image empty(int channels) const {
    return Image(surface_.mask.width(), surface_.mask.height(), channels);
  }
  static Image scaled(Image image, double factor) {
    for (float& value : image.values()) value = float(factor * double(value));
    return image;
  }
  static void add(LayerAgreement& agreement, const std::string& name, Image measured,
                  Image expected, Image bound) {
    agreement.measured.add(name, std::move(measured));
    agreement.expected.add(name, std::move(expected));
    agreement.bounds.add(name, std::move(bound));
  }

  template <typename Body>
  void for_each_pixel_sum(const Body& body) const {
    const auto add_group = [&, visibility = visibility_](const PixelGroup& group, int set) mutable {
      visibility.set_group(group, long(samples_.directions.size()));
      std::array<DirectSums, lane_count> sums;
      std::array<LightAtPoint, lane_count> light;
      for (std::size_t i = 0; i < lane_count; ++i) {
        light[i] = light_at(lighting_, group.position[i]);
      }
      for (const glm::vec4& sample : samples_.directions) {
        const float xi = fract(sample.w + samples_.sets[std::size_t(set)].z);
        const Lanes visible =
            visibility.toward(glm::vec3(sample), tangent_cell(glm::vec3(sample)), xi);
        for (std::size_t i = 0; i < lane_count; ++i) {
          const glm::mat3 frame(at(group.frame.tangent, int(i)), at(group.frame.bitangent, int(i)),
                                at(group.frame.normal, int(i)));
          sums[i].add(light[i], frame * glm::vec3(sample), double(visible.v[i]), double(sample.z));
        }
      }
      for (std::size_t i = 0; i < lane_count; ++i) {
        if (group.active.v[i] != 0) body(group.pixel[i], sums[i]);
      }
    };
    for_each_group(surface_, samples_, TurnPattern::interleaved, add_group);
  }

  void add_direct_sums(LayerAgreement& agreement, const Image& sh) const {
    const double N = constants_.samples;
    const double light_rounding =
        (N + 30.0 + 20.0 * double(lighting_.lights().size())) * half_last_place;
    const double share_rounding = (2.0 * N + 16.0) * half_last_place;
    Image radiance = empty(3);
    Image radiance_bound = empty(3);
    Image bent = empty(3);
    Image bent_bound = empty(3);
    Image visible = empty(1);
    for_each_pixel_sum([&](glm::ivec2 at, const DirectSums& sums) {
      for (int c = 0; c < 3; ++c) {
        const double scale = 2.0 / N * double(surface_.albedo.at(at.x, at.y, c));
        radiance.at(at.x, at.y, c) = float(scale * sums.light[c]);
        radiance_bound.at(at.x, at.y, c) = float(scale * light_rounding * sums.magnitude[c]);
        if (sums.visible <= 0.0) continue;
        bent.at(at.x, at.y, c) = float(sums.direction[c] / sums.visible);
        bent_bound.at(at.x, at.y, c) = float(share_rounding);  // no component is above 1
      }
      visible.at(at.x, at.y) = float(sums.visible / N);
    });
    add(agreement, "s3ho_radiance", light_on_cpu(representation("s3ho"), sh, surface_, lighting_),
        std::move(radiance), std::move(radiance_bound));
    Layers bent_cone;
    representation("ssbn").add_layers(values("ssbn"), bent_cone);
    add(agreement, "ssbn_bent_normal", bent_cone.at("bent_normal"), std::move(bent),
        std::move(bent_bound));
    Image bound = scaled(visible, share_rounding);
    add(agreement, "ssbn_uniform_occlusion", bent_cone.at("uniform_occlusion"), std::move(visible),
        std::move(bound));
  }

  void add_constant_probe(LayerAgreement& agreement, const Image& occlusion,
                          double rounding) const {
    const Lighting lighting(constant_environment(constant_radiance), {}, frame_.view);
    const CpuLighting constant(lighting, constants_);
    Image sums = empty(3);
    const std::array<const Representation*, 1> ssdo = {&representation("ssdo")};
    add_directions({surface_, constant, constants_, visibility_}, samples_,
                   TurnPattern::interleaved, ssdo, std::span(&sums, 1));
    Image expected = empty(3);
    for (std::size_t p = 0; p < occlusion.pixel_count(); ++p) {
      for (std::size_t c = 0; c < 3; ++c) {
        expected.values()[3 * p + c] = float(std::numbers::pi * double(occlusion.values()[p]) *
                                             double(constant_radiance[int(c)]));
      }
    }
    Image bound = scaled(expected, rounding);
    add(agreement, "ssdo_irradiance", representation_of(*ssdo[0], sums, constants_.samples),
        std::move(expected), std::move(bound));
  }

  const Frame& frame_;
  const ParameterSet& parameters_;
  const PassConstants& constants_;
  const GBufferImages& surface_;
  const CpuLighting& lighting_;
  VisibilitySource visibility_;
  SampleSet samples_;
};

}  // namespace

LayerAgreement representation_identities(const Frame& frame, const ParameterSet& parameters) {
  const PassConstants constants = pass_constants(parameters);
  const CpuLighting lighting(frame.lighting, constants);
  return Identities(frame, parameters, constants, lighting).all();
}

}  // namespace occlab
