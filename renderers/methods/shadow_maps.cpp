#include "renderers/methods/shadow_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "renderers/gl/context.h"
#include "renderers/methods/hidden_facts.h"
#include "renderers/methods/pass_constants.h"
#include "renderers/methods/representation_layers.h"
#include "renderers/scene/error.h"
#include "renderers/scene/interrupt.h"

namespace occlab {
namespace {

/// Units and bindings, as screen_space.glsl and the passes declare them.
enum TextureUnit : GLuint {
  unit_position,
  unit_normal,
  unit_albedo,
  unit_input = 5,
  unit_maps,
  unit_hidden_position = 11
};
constexpr GLuint binding_lights = 1;

/// By how much a surface may be farther than its map says, whatever its bias: what rounding does to
/// positions, as a share of the sphere around the scene. As high above surfaces the reference's
/// rays start.
constexpr float rounding_share = 1e-5f;

/// Those of the screen-space methods that the test for blockers takes.
std::vector<Parameter> blocker_test_parameters() {
  std::vector<Parameter> all = screen_space_parameters();
  std::erase_if(all, [](const Parameter& parameter) {
    const std::array<std::string, 6> taken = {"visibility", "layers",        "d_max_world",
                                              "bias_world", "epsilon_world", "gbuffer_bits"};
    return std::ranges::find(taken, parameter.name) == taken.end();
  });
  Parameter& visibility = *std::ranges::find(all, "visibility", &Parameter::name);
  visibility.choices = {"depth", "peeled"};
  visibility.help =
      "what the correction looks for blockers in: the depth buffer, or several layers of it [SSDO "
      "sec. 4, Fig. 9]";
  return all;
}

/// The layers behind the first that the correction looks at, if it does.
std::optional<HiddenSettings> correction_layers(const ParameterSet& parameters) {
  if (parameters.integer("correction_samples") == 0) return std::nullopt;
  std::optional<HiddenSettings> settings = hidden_settings(parameters);
  if (settings) settings->complete = false;
  return settings;
}

/// The march of screen_space.glsl is along the bias here: its steps are the correction's samples.
std::string correction_march(const ParameterSet& parameters) {
  std::string glsl =
      "#undef PARAMETER_steps\n#define PARAMETER_steps PARAMETER_correction_samples\n";
  if (const auto layers = correction_layers(parameters)) {
    glsl += fmt::format("#define HIDDEN_LAYERS {}\n", layers->count);
  }
  return glsl + binary_march(parameters);
}

PunctualLight in_view(const PunctualLight& light, const glm::mat4& view_from_world) {
  const glm::vec4 position(glm::vec3(light.position_and_type), 1.0f);
  const glm::vec4 direction(glm::vec3(light.direction_and_outer), 0.0f);
  return {glm::vec4(glm::vec3(view_from_world * position), light.position_and_type.w),
          glm::vec4(glm::vec3(view_from_world * direction), light.direction_and_outer.w),
          light.intensity_and_inner};
}

void set_projection(const Program& program, const LightProjection& projection,
                    const glm::mat4& world_from_view) {
  program.set("light_from_view", projection.light_from_world * world_from_view);
  program.set("face_count", projection.faces());
  program.set("map_low", projection.low);
  program.set("map_high", projection.high);
  for (int face = 0; face < projection.faces(); ++face) {
    program.set(fmt::format("face_from_light[{}]", face).c_str(),
                projection.face_from_light[std::size_t(face)]);
  }
}

class ShadowMapMethod final : public OcclusionMethod {
 public:
  void render(const Frame& frame, const ParameterSet& parameters) override {
    const Framebuffer& irradiance = light_target(irradiance_, frame.view);
    const Framebuffer& radiance = light_target(radiance_, frame.view);
    const DirectLights lights = direct_lights(frame, parameters);
    draw_layers(frame, parameters);
    frame.clock("occlusion", [&] {
      clear_light(irradiance);
      lighting_.add(frame, parameters, lights.punctual, irradiance);
      lighting_.add(frame, parameters, lights.environment, irradiance);
    });
    frame.clock("lighting", [&] {
      light_surfaces(frame, parameters, irradiance.colors().front(), radiance, Into::replaced);
    });
    check_gl("a method with shadow maps");
  }

  Layers evaluate(const Frame& frame, const ParameterSet& parameters, Metadata& facts) override {
    render(frame, parameters);
    add_shadow_map_facts(frame, parameters, facts);
    Layers layers;
    layers.add("radiance", channels_of(radiance_->colors().front().download(), 0, 3));
    layers.add("irradiance", channels_of(irradiance_->colors().front().download(), 0, 3));
    return layers;
  }

 private:
  MappedLighting lighting_;
  std::optional<Framebuffer> irradiance_;
  std::optional<Framebuffer> radiance_;
};

}  // namespace

std::string binary_march(const ParameterSet& parameters) {
  std::string glsl = "#define PARAMETER_weight 0\n";
  for (const char* name : {"lambda_per_world", "fade_start"}) {
    if (!parameters.has(name)) glsl += fmt::format("uniform float {};\n", name);
  }
  return glsl;
}

std::vector<Parameter> shadow_map_parameters() {
  std::vector<Parameter> parameters = of_factor(
      Factor::lighting,
      {integer_parameter("environment_lights", 256, 0, 1024, "",
                         "directional lights that stand for the environment; the paper has 256 "
                         "[SSDO sec. 5]"),
       seed_parameter("draws the environment's lights")});
  std::ranges::move(
      of_factor(Factor::visibility,
                {integer_parameter("shadow_map_side", 512, 16, 4096, "texels",
                                   "of each light's depth maps; the paper has 512 and 1024 [SSDO "
                                   "Figs. 9, 10]"),
                 choice_parameter("shadow_bias", {"none", "slope"},
                                  "none, or b = (p/2) tan(alpha) of the patch size p and the "
                                  "light's angle to the normal [SSDO sec. 5]"),
                 real_parameter("most_slope", 20.0, 0.0, 1e4, "",
                                "tan(alpha) counts for at most this; unstated in the paper"),
                 integer_parameter("correction_samples", 8, 0, 64, "",
                                   "tests for blockers between P and P + b l; 0 for no correction; "
                                   "the paper has 8 and 16 [SSDO sec. 5, Fig. 9]")}),
      std::back_inserter(parameters));
  for (Parameter& parameter : parameters) {
    if (parameter.name == "shadow_bias") parameter.default_value = "slope";
    parameter.in_shaders &=
        parameter.name != "environment_lights" && parameter.name != "shadow_map_side";
  }
  std::ranges::move(blocker_test_parameters(), std::back_inserter(parameters));
  return parameters;
}

DirectLights direct_lights(const Frame& frame, const ParameterSet& parameters) {
  const auto count = int(parameters.integer("environment_lights"));
  if (frame.lighting.lights().empty() && count == 0) {
    throw InputError(fmt::format(
        "{}: environment_lights is 0 and the scene has no light of its own: nothing lights it; "
        "accepted: environment_lights of 1 or more, or a scene with lights",
        frame.scene.path.string()));
  }
  const SceneSphere sphere = sphere_around(frame.scene);
  return {mapped_lights(frame.lighting.lights(), sphere),
          environment_lights(frame.lighting.environment(), count,
                             std::uint64_t(parameters.integer("seed")), sphere)};
}

const Program& use_frame_program(const Frame& frame, const ParameterSet& parameters,
                                 const std::string& shader, const std::string& preamble) {
  // Before use(): the first call draws the G-buffer with a program of its own.
  const GBuffer& gbuffer = frame.gbuffer(gbuffer_bits(parameters));
  const Program& program = frame.programs.get(
      fullscreen_vertex_shader, shader,
      parameters.glsl_preamble() + "#define PROBE_SIDE 1\n#define LIGHT_COUNT 1\n" + preamble);
  program.use();
  for (const Parameter& parameter : parameters.declared()) {
    if (parameter.kind == ParameterKind::real) {
      program.set(parameter.name.c_str(), parameters.real32(parameter.name));
    }
  }
  program.set("focal_pixels", frame.view.focal_pixels());
  program.set("image_center", 0.5f * glm::vec2(frame.view.width, frame.view.height));
  Program::bind_texture(unit_position, gbuffer.position_view());
  Program::bind_texture(unit_normal, gbuffer.normal_view());
  Program::bind_texture(unit_albedo, gbuffer.albedo());
  return program;
}

const ShadowMaps& MappedLighting::maps(int side, int faces) {
  if (!maps_ || maps_->side() != side || maps_->faces() < faces) {
    maps_.reset();
    maps_.emplace(side, faces);
  }
  return *maps_;
}

void MappedLighting::add(const Frame& frame, const ParameterSet& parameters,
                         const std::vector<MappedLight>& lights, const Framebuffer& target) {
  int most_faces = 1;
  for (const MappedLight& light : lights) {
    most_faces = std::max(most_faces, light.projection.faces());
  }
  const ShadowMaps& shadow_maps = maps(int(parameters.integer("shadow_map_side")), most_faces);
  const float rounding = rounding_share * sphere_around(frame.scene).radius;
  const std::optional<HiddenSettings> layers = correction_layers(parameters);
  for (const MappedLight& light : lights) {
    throw_if_interrupted();
    shadow_maps.draw(light.projection, frame.scene, frame.gpu_scene, frame.programs);
    const Program& program = use_frame_program(
        frame, parameters, mapped_light_shader,
        correction_march(parameters) +
            fmt::format("#define VIRTUAL_LIGHT {}\n#define PARALLEL_RAYS {}\n",
                        light.is_virtual ? 1 : 0, light.projection.parallel ? 1 : 0));
    set_projection(program, light.projection, frame.view.camera.world_from_camera);
    program.set("rounding_world", rounding);
    const PunctualLight light_view = in_view(light.light, frame.view.view_from_world());
    const Buffer light_buffer(&light_view, sizeof(light_view));
    Program::bind_uniform_buffer(binding_lights, light_buffer);
    const GBuffer& gbuffer = frame.gbuffer(gbuffer_bits(parameters));
    Program::bind_texture(unit_input, gbuffer.geometric_normal_view());
    Program::bind_texture(unit_maps, shadow_maps.distance());
    if (layers) {
      Program::bind_texture(unit_hidden_position, frame.hidden(*layers).position_view());
    }
    target.bind();
    add_fullscreen();
  }
}

void draw_layers(const Frame& frame, const ParameterSet& parameters) {
  const std::optional<HiddenSettings> settings = correction_layers(parameters);
  if (!settings) return;
  const HiddenSurfaces& layers = frame.hidden(*settings);
  const GBuffer& first = frame.gbuffer(settings->bits);
  frame.clock("layers", [&] {
    layers.draw(frame.scene, frame.gpu_scene, frame.view, first, frame.programs);
  });
}

void add_shadow_map_facts(const Frame& frame, const ParameterSet& parameters, Metadata& facts) {
  const DirectLights lights = direct_lights(frame, parameters);
  facts["punctual_lights"] = std::to_string(lights.punctual.size());
  facts["environment_lights"] = std::to_string(lights.environment.size());
  if (const auto settings = correction_layers(parameters)) {
    add_hidden_facts(frame, *settings, facts);
  }
}

void light_surfaces(const Frame& frame, const ParameterSet& parameters, const Texture& irradiance,
                    const Framebuffer& target, Into into) {
  use_frame_program(frame, parameters, surface_lighting_shader, correction_march(parameters));
  Program::bind_texture(unit_input, irradiance);
  target.bind();
  if (into == Into::added) {
    add_fullscreen();
  } else {
    draw_fullscreen();
  }
}

void clear_light(const Framebuffer& target) {
  target.bind();
  glClearColor(0.0f, 0.0f, 0.0f, 0.0f);
  glClear(GL_COLOR_BUFFER_BIT);
}

const Framebuffer& light_target(std::optional<Framebuffer>& target, const View& view) {
  if (!target || target->colors().front().width() != view.width ||
      target->colors().front().height() != view.height) {
    const std::array<GLenum, 1> format = {GL_RGBA32F};
    target.emplace(view.width, view.height, format, false);
  }
  return *target;
}

MethodInfo shadow_maps() {
  return {.name = "shadow_maps",
          .title = "Shadow maps",
          .paper = "Ritschel, Grosch, Seidel 2009, section 5",
          .parameters = shadow_map_parameters(),
          .layers = {"irradiance"},
          .shaders = {mapped_light_shader, surface_lighting_shader},
          .make = [] { return std::make_unique<ShadowMapMethod>(); }};
}

}  // namespace occlab
