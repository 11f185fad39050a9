#include "harness/verify/representation_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "harness/verify/reference_identities.h"
#include "harness/verify/representation_identities.h"
#include "renderers/gl/context.h"
#include "renderers/methods/representation.h"
#include "renderers/scene/data_root.h"

namespace occlab {
namespace {

constexpr const char* subject = "representations";
constexpr int width = 160;
constexpr int height = 90;
constexpr int small_width = 64;  ///< of what is replicated
constexpr int small_height = 36;
constexpr int order4_width = 256;

/// A scene on the device, seen by one of its cameras.
class SceneOnDevice {
 public:
  SceneOnDevice(const std::string& name, ProgramCache& programs)
      : scene_(load_scene(scene_path(name))), gpu_scene_(scene_), programs_(programs) {}

  const std::string& name() const { return scene_.name; }
  const std::vector<Camera>& cameras() const { return scene_.cameras; }
  const std::vector<Light>& lights() const { return scene_.lights; }

  Frame frame(const View& view, Environment environment, std::vector<Light> lights) const {
    return {.scene = scene_,
            .gpu_scene = gpu_scene_,
            .view = view,
            .lighting = Lighting(std::move(environment), std::move(lights), view),
            .programs = programs_};
  }

 private:
  Scene scene_;
  GpuScene gpu_scene_;
  ProgramCache& programs_;
};

Environment sun_and_sky() {
  return load_environment({.source = "sky_sun", .rotation_degrees = 30.0f});
}

std::string file_name(std::string text) {
  std::ranges::replace_if(
      text, [](unsigned char c) { return std::isalnum(c) == 0 && c != '-'; }, '_');
  return text;
}

/// Leaves the images of a check that failed.
void keep_images(Check& check, const LayerAgreement& agreement,
                 const RepresentationSettings& settings, const std::string& what,
                 const std::string& parameters) {
  if (check.passes) return;
  const auto folder = settings.output / file_name(fmt::format("{}-{}", subject, what));
  write_agreement(agreement, folder,
                  {{"occlab:check", check.name}, {"occlab:parameters", parameters}});
  check.detail += fmt::format("; images: {}", folder.string());
}

/// The worst pixel of several agreements, and where it was.
struct Worst {
  WorstPixel pixel;
  LayerAgreement agreement;
  std::string where;
  std::string parameters;

  void consider(LayerAgreement other, const std::string& of, const ParameterSet& with) {
    const WorstPixel candidate = worst_pixel(other);
    if (!pixel.layer.empty() && candidate.share <= pixel.share) return;
    *this = {candidate, std::move(other), of, with.to_string()};
  }
};

/// A check of |measured - expected| / bound, which must not exceed 1.
Check share_check(const Worst& worst, std::string name, const std::string& quantity,
                  std::string rule) {
  return checked({.subject = subject,
                  .name = std::move(name),
                  .quantity = fmt::format("{}, largest of its bound: {}[{}] at ({}, {})", quantity,
                                          worst.pixel.layer, worst.pixel.channel, worst.pixel.x,
                                          worst.pixel.y),
                  .measured = worst.pixel.share,
                  .expected = 0.0,
                  .bound = 1.0,
                  .rule = std::move(rule),
                  .detail = fmt::format("{}: {}", worst.where, describe(worst.pixel))});
}

/// NAME=VALUE settings that CPU and GPU are compared with, where a method has NAME.
constexpr std::array<std::pair<const char*, const char*>, 7> variants = {
    {{"weight", "binary"},
     {"weight", "lambda"},
     {"weight", "smoothstep"},
     {"gbuffer_bits", "16"},
     {"cone_angle", "exact"},
     {"form_factor", "solid_angle"},
     {"form_factor", "patch"}}};

Check gpu_check(const SceneOnDevice& scene, const Frame& frame, const MethodInfo& method,
                const RepresentationSettings& settings) {
  Worst worst;
  for (const auto& [name, value] : variants) {
    ParameterSet parameters(method.parameters);
    if (!parameters.has(name)) continue;
    parameters.set_text(name, value);
    worst.consider(gpu_and_cpu(frame, method, parameters), fmt::format("{}={}", name, value),
                   parameters);
  }
  const std::string view = fmt::format("{}, {}", scene.name(), frame.view.camera.name);
  const char* const rule = method.representation->storage_error > 0.0f
                               ? "each pass: 2^-11 of a value stored as half, 2^-17 for floats; "
                                 "light: what that makes of E"
                               : "each pass: 2^-17 of a value; light: what that makes of E";
  Check check = share_check(worst, fmt::format("{}: {} on GPU and CPU", view, method.title),
                            "|GPU - CPU|", rule);
  keep_images(check, worst.agreement, settings,
              fmt::format("{}-{}-{}", scene.name(), frame.view.camera.name, method.name),
              worst.parameters);
  return check;
}

/// What a layer of representation_identities() says.
struct Identity {
  const char* layer;
  const char* name;
};
constexpr std::array<Identity, 5> identities = {{
    {"s3ho_radiance", "S3HO is a sum over directions: E = (2 pi/N) sum V L4(s) (n.s)"},
    {"s3ho_ambient_occlusion", "SSAO is S3HO's first coefficient: k_A = (2/sqrt pi) c_0"},
    {"ssbn_bent_normal", "SSBN is a sum over directions: N = sum V s / sum V"},
    {"ssbn_uniform_occlusion", "SSBN is a sum over directions: AO = sum V / N"},
    {"ssdo_irradiance", "SSDO under a constant probe is SSAO: E = pi k_A L"},
}};

LayerAgreement one_layer(const LayerAgreement& all, const std::string& layer) {
  LayerAgreement one;
  one.measured.add(layer, all.measured.at(layer));
  one.expected.add(layer, all.expected.at(layer));
  one.bounds.add(layer, all.bounds.at(layer));
  return one;
}

using WorstIdentities = std::array<Worst, identities.size()>;

void consider_identities(WorstIdentities& worst, const std::string& scene, const Frame& frame) {
  for (const char* source : {"depth", "traced"}) {
    ParameterSet parameters(find_method("s3ho").parameters);
    parameters.set_text("visibility", source);
    const LayerAgreement all = representation_identities(frame, parameters);
    for (std::size_t i = 0; i < identities.size(); ++i) {
      worst[i].consider(one_layer(all, identities[i].layer),
                        fmt::format("{}, {}, visibility={}", scene, frame.view.camera.name, source),
                        parameters);
    }
  }
}

void add_identity_checks(Checks& checks, const WorstIdentities& worst,
                         const RepresentationSettings& settings) {
  for (std::size_t i = 0; i < identities.size(); ++i) {
    Check check = share_check(worst[i], identities[i].name, "|left - right|",
                              "2^-24 of the terms' magnitudes for each operation");
    keep_images(check, worst[i].agreement, settings, identities[i].layer, worst[i].parameters);
    checks.push_back(std::move(check));
  }
}

/// One scene's replicates, to be judged when the number of tests is known.
struct Replicated {
  std::string scene;
  std::string parameters;
  ReferenceComparison comparison;
};

Replicated replicate(const SceneOnDevice& scene) {
  const Frame frame = scene.frame({scene.cameras().front(), small_width, small_height},
                                  order4_environment(sun_and_sky(), order4_width), {});
  const ParameterSet parameters(find_method("s3ho").parameters);
  return {scene.name(), parameters.to_string(), compare_to_reference(frame, parameters, {})};
}

constexpr std::array<std::pair<const char*, const char*>, 3> reference_rows = {
    {{"ssao_ambient_occlusion", "SSAO's k_A is RTDO's"},
     {"s3ho_radiance", "S3HO is RTDO under the probe's order-4 SH"},
     {"ssdo_radiance", "SSDO is RTDO"}}};

Check reference_check(const Replicated& done, const char* layer, const char* name, int tests,
                      const RepresentationSettings& settings) {
  const int replicates = Replication{}.replicates;
  const double critical = critical_standard_errors(representation_family_level, tests, replicates);
  const RegionMeans& worst = worst_region(done.comparison, layer);
  Check check = checked(
      {.subject = subject,
       .name = fmt::format("{}: with traced visibility {}", done.scene, name),
       .quantity = fmt::format("{}[{}] of {}", layer, worst.channel, worst.region),
       .measured = worst.measured,
       .expected = worst.expected,
       .bound = critical * worst.standard_error,
       .rule = fmt::format("{:.3g} standard errors (t, {} d.f., Sidak over {} tests at {:g})",
                           critical, replicates - 1, tests, representation_family_level),
       .detail = fmt::format("standard error {:.3g}", worst.standard_error)});
  keep_images(check, one_layer(done.comparison.images, layer), settings,
              fmt::format("{}-{}", done.scene, layer), done.parameters);
  return check;
}

}  // namespace

Checks verify_representations(const RepresentationSettings& settings) {
  const Context context(settings.device);
  ProgramCache programs;
  Checks checks;
  WorstIdentities worst_identities;
  std::vector<Replicated> replicated;
  for (const std::string& name : scene_names()) {
    const SceneOnDevice scene(name, programs);
    for (const Camera& camera : scene.cameras()) {
      const Frame frame = scene.frame({camera, width, height}, sun_and_sky(), scene.lights());
      for (const MethodInfo& method : methods()) {
        if (method.representation == nullptr) continue;
        checks.push_back(gpu_check(scene, frame, method, settings));
      }
      consider_identities(worst_identities, scene.name(), frame);
    }
    replicated.push_back(replicate(scene));
  }
  add_identity_checks(checks, worst_identities, settings);
  int tests = 0;
  for (const Replicated& done : replicated) tests += int(done.comparison.regions.size());
  for (const Replicated& done : replicated) {
    for (const auto& [layer, row] : reference_rows) {
      checks.push_back(reference_check(done, layer, row, tests, settings));
    }
  }
  return checks;
}

}  // namespace occlab
