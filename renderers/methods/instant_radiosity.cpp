#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string_view>

#include "renderers/gl/context.h"
#include "renderers/methods/pass_constants.h"
#include "renderers/methods/representation_layers.h"
#include "renderers/methods/sample_set.h"
#include "renderers/methods/sample_shader.h"
#include "renderers/methods/shadow_maps.h"

namespace occlab {
namespace {

constexpr const char* near_bounce_shader = "renderers/methods/instant_radiosity_bounce.frag";
constexpr const char* filter_shader = "renderers/methods/bilateral.frag";
constexpr GLuint unit_input = 5;
constexpr GLuint binding_samples = 0;

std::vector<Parameter> virtual_light_parameters() {
  std::vector<Parameter> parameters = {
      integer_parameter("bounce_lights", 256, 0, 1024, "",
                        "virtual point lights of the lights' first bounce; unstated in the paper "
                        "[SSDO sec. 5, Fig. 11]"),
      integer_parameter("reflective_map_side", 256, 16, 1024, "texels",
                        "of the reflective shadow maps that they are drawn from; unstated in the "
                        "paper"),
      real_parameter("bounce_clamp_world", 0.1, 1e-6, 1e6, "scene units",
                     "distance below which a virtual point light gives no more light; unstated in "
                     "the paper [SSDO sec. 5]"),
      choice_parameter(
          "near_bounce", {"none", "screen"},
          "what is missing within that distance: nothing for it, or a bounce in screen "
          "space, which sends the missing share [SSDO sec. 5, Fig. 12]"),
  };
  for (Parameter& parameter : parameters) {
    parameter.in_shaders = parameter.name == "bounce_clamp_world";
  }
  return of_factor(Factor::lighting, parameters);
}

/// Those of the screen-space methods that the bounce nearby has.
std::vector<Parameter> near_bounce_parameters() {
  std::vector<Parameter> all = screen_space_parameters();
  std::erase_if(all, [](const Parameter& parameter) {
    return parameter.name != "samples" && parameter.name != "steps" &&
           !parameter.name.starts_with("filter");
  });
  std::ranges::move(bounce_parameters("solid_angle"), std::back_inserter(all));
  return all;
}

std::vector<Parameter> all_parameters() {
  std::vector<Parameter> all = shadow_map_parameters();
  std::ranges::move(virtual_light_parameters(), std::back_inserter(all));
  std::ranges::move(near_bounce_parameters(), std::back_inserter(all));
  return all;
}

bool bounces_nearby(const ParameterSet& parameters) {
  return parameters.choice("near_bounce") == "screen";
}

class InstantRadiosity final : public OcclusionMethod {
 public:
  void render(const Frame& frame, const ParameterSet& parameters) override {
    prepare(frame.view);
    const DirectLights lights = direct_lights(frame, parameters);
    draw_layers(frame, parameters);
    frame.clock("virtual_lights", [&] { make_virtual_lights(frame, parameters, lights); });
    frame.clock("occlusion", [&] {
      clear_light(*direct_);
      lighting_.add(frame, parameters, lights.punctual, *direct_);
      lighting_.add(frame, parameters, lights.environment, *direct_);
    });
    frame.clock("indirect", [&] {
      clear_light(*indirect_);
      lighting_.add(frame, parameters, virtual_lights_, *indirect_);
    });
    if (bounces_nearby(parameters)) {
      run_near_bounce(frame, parameters);
      if (filters(parameters)) run_filter(frame, parameters);
    }
    frame.clock("lighting", [&] { light(frame, parameters, Part::all, shown(parameters)); });
    check_gl("instant radiosity");
  }

  Layers evaluate(const Frame& frame, const ParameterSet& parameters, Metadata& facts) override {
    render(frame, parameters);
    add_shadow_map_facts(frame, parameters, facts);
    facts["virtual_lights"] = std::to_string(virtual_lights_.size());
    Layers layers;
    layers.add("radiance", read(*radiance_));
    layers.add("irradiance", read(*direct_));
    layers.add("radiance_indirect", lit(frame, parameters, Part::indirect, shown(parameters)));
    if (bounces_nearby(parameters) && filters(parameters)) {
      layers.add("radiance_unfiltered", lit(frame, parameters, Part::all, *near_));
      layers.add("radiance_indirect_unfiltered", lit(frame, parameters, Part::indirect, *near_));
    }
    check_gl("reading instant radiosity back");
    return layers;
  }

 private:
  enum class Part { all, indirect };

  void prepare(const View& view) {
    for (auto* target : {&direct_, &indirect_, &near_, &filtered_, &radiance_}) {
      light_target(*target, view);
    }
  }

  void make_virtual_lights(const Frame& frame, const ParameterSet& parameters,
                           const DirectLights& lights) {
    virtual_lights_ = virtual_lights(lights.punctual, int(parameters.integer("bounce_lights")),
                                     int(parameters.integer("reflective_map_side")),
                                     std::uint64_t(parameters.integer("seed")), frame.scene,
                                     frame.gpu_scene, frame.programs);
  }

  /// Senders show the direct light. Blockers count within the clamp's distance.
  void run_near_bounce(const Frame& frame, const ParameterSet& parameters) {
    frame.clock("senders", [&] {
      light_surfaces(frame, parameters, direct_->colors().front(), *radiance_, Into::replaced);
    });
    const SampleSet samples = make_sample_set(int(parameters.integer("samples")),
                                              std::uint64_t(parameters.integer("seed")));
    std::vector<glm::vec4> block(samples.sets.begin(), samples.sets.end());
    block.insert(block.end(), samples.directions.begin(), samples.directions.end());
    const Buffer sample_buffer(block.data(), block.size() * sizeof(glm::vec4));
    const Program& program = use_frame_program(
        frame, parameters, near_bounce_shader,
        sample_constants(int(parameters.integer("samples")), int(parameters.integer("steps"))) +
            binary_march(parameters));
    program.set("d_max_world", parameters.real32("bounce_clamp_world"));
    Program::bind_texture(unit_input, radiance_->colors().front());
    Program::bind_uniform_buffer(binding_samples, sample_buffer);
    near_->bind();
    frame.clock("bounce", draw_fullscreen);
  }

  void run_filter(const Frame& frame, const ParameterSet& parameters) {
    PassConstants constants;
    constants.filter_power = parameters.real32("filter_power");
    const Program& program =
        use_frame_program(frame, parameters, filter_shader,
                          binary_march(parameters) +
                              fmt::format("#define WHOLE_FILTER_POWER {}\n#define TARGET_COUNT "
                                          "1\n#define INTEGER_TARGETS 0\n",
                                          whole_filter_power(constants)));
    program.set("d_max_world", parameters.real32("bounce_clamp_world"));
    Program::bind_texture(unit_input, near_->colors().front());
    filtered_->bind();
    frame.clock("filter", draw_fullscreen);
  }

  const Framebuffer& shown(const ParameterSet& parameters) const {
    return filters(parameters) ? *filtered_ : *near_;
  }

  void light(const Frame& frame, const ParameterSet& parameters, Part part,
             const Framebuffer& nearby) {
    clear_light(*radiance_);
    const auto add = [&](const Framebuffer& irradiance) {
      light_surfaces(frame, parameters, irradiance.colors().front(), *radiance_, Into::added);
    };
    if (part == Part::all) add(*direct_);
    add(*indirect_);
    if (bounces_nearby(parameters)) add(nearby);
  }

  Image lit(const Frame& frame, const ParameterSet& parameters, Part part,
            const Framebuffer& nearby) {
    light(frame, parameters, part, nearby);
    return read(*radiance_);
  }

  static Image read(const Framebuffer& target) {
    return channels_of(target.colors().front().download(), 0, 3);
  }

  MappedLighting lighting_;
  std::vector<MappedLight> virtual_lights_;
  std::optional<Framebuffer> direct_;    ///< irradiance, as are the next three
  std::optional<Framebuffer> indirect_;  ///< of virtual lights
  std::optional<Framebuffer> near_;      ///< what their clamp leaves out
  std::optional<Framebuffer> filtered_;  ///< the same
  std::optional<Framebuffer> radiance_;
};

}  // namespace

MethodInfo instant_radiosity() {
  return {
      .name = "instant_radiosity",
      .title = "Instant radiosity",
      .paper = "Ritschel, Grosch, Seidel 2009, section 5; Keller 1997",
      .parameters = all_parameters(),
      .layers = {"irradiance", "radiance_indirect", "radiance_indirect_unfiltered"},
      .shaders = {mapped_light_shader, surface_lighting_shader, near_bounce_shader, filter_shader},
      .make = [] { return std::make_unique<InstantRadiosity>(); },
      .truth = "rtgi_shaded"};
}

}  // namespace occlab
