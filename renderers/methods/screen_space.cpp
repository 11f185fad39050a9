#include "renderers/methods/screen_space.h"

#include <fmt/format.h>

#include <array>

#include "renderers/gl/context.h"
#include "renderers/methods/cpu_bounce.h"
#include "renderers/methods/cpu_passes.h"
#include "renderers/methods/frame.h"
#include "renderers/methods/hidden_facts.h"
#include "renderers/methods/representation_layers.h"
#include "renderers/methods/sample_set.h"
#include "renderers/methods/sample_shader.h"

namespace occlab {
namespace {

constexpr const char* filter_shader = "renderers/methods/bilateral.frag";

/// Units and bindings, as screen_space.glsl declares them.
enum TextureUnit : GLuint {
  unit_position,
  unit_normal,
  unit_albedo,
  unit_probe,
  unit_cones,
  unit_input,
  unit_hidden_position = 11,
  unit_hidden_normal,
  unit_hidden_albedo,
};
enum BufferBinding : GLuint { binding_samples, binding_lights, binding_sh };

std::string preamble(const Frame& frame, const ParameterSet& parameters,
                     const ScreenSpacePasses& passes) {
  const std::vector<GLenum>& formats = passes.representation_formats;
  return fmt::format(
      "{}{}#define WHOLE_FILTER_POWER {}\n#define PROBE_SIDE {}\n#define LIGHT_COUNT {}\n#define "
      "TARGET_COUNT {}\n"
      "#define INTEGER_TARGETS {}\n",
      parameters.glsl_preamble(),
      sample_constants(int(parameters.integer("samples")), int(parameters.integer("steps"))),
      whole_filter_power(pass_constants(parameters)),
      passes.representation->reads_radiance ? frame.lighting.octahedral_probe().width() : 1,
      frame.lighting.lights().size(), formats.size(), formats.front() == GL_RGBA32UI ? 1 : 0);
}

/// What the march looks up beside the first surfaces.
std::string hidden_preamble(const std::optional<HiddenSettings>& settings) {
  if (!settings) return {};
  return fmt::format("#define HIDDEN_{} {}\n",
                     settings->kind == HiddenKind::layers ? "LAYERS" : "CAMERAS", settings->count);
}

void hand_over(const HiddenSurfaces& hidden, const Program& program) {
  Program::bind_texture(unit_hidden_position, hidden.position_view());
  if (hidden.settings().complete) {
    Program::bind_texture(unit_hidden_normal, hidden.normal_view());
    Program::bind_texture(unit_hidden_albedo, hidden.albedo());
  }
  const std::vector<HiddenCamera>& cameras = hidden.cameras();
  if (cameras.empty()) return;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    program.set(fmt::format("camera_from_view[{}]", i).c_str(), cameras[i].camera_from_view);
  }
  const View& view = cameras.front().view;
  program.set("camera_center", 0.5f * glm::vec2(view.width, view.height));
  program.set("camera_focal_pixels", view.focal_pixels());
}

/// Uses the program and hands it what every pass may read.
const Program& use_program(const Frame& frame, const ParameterSet& parameters,
                           const std::string& shader, const ScreenSpacePasses& passes,
                           const std::string& own_preamble = {}) {
  // Before use(): the first calls draw with programs of their own.
  const GBuffer& gbuffer = frame.gbuffer(gbuffer_bits(parameters));
  const std::optional<HiddenSettings> settings = hidden_settings(parameters);
  const HiddenSurfaces* const hidden = settings ? &frame.hidden(*settings) : nullptr;
  const Program& program = frame.programs.get(
      fullscreen_vertex_shader, shader,
      preamble(frame, parameters, passes) + hidden_preamble(settings) + own_preamble);
  program.use();
  if (hidden) hand_over(*hidden, program);
  for (const Parameter& parameter : parameters.declared()) {
    if (parameter.kind == ParameterKind::real) {
      program.set(parameter.name.c_str(), parameters.real32(parameter.name));
    }
  }
  const View& view = frame.view;
  program.set("focal_pixels", view.focal_pixels());
  program.set("image_center", 0.5f * glm::vec2(view.width, view.height));
  program.set("probe_from_view", frame.lighting.probe_from_view());
  Program::bind_texture(unit_position, gbuffer.position_view());
  Program::bind_texture(unit_normal, gbuffer.normal_view());
  Program::bind_texture(unit_albedo, gbuffer.albedo());
  if (passes.representation->reads_radiance) {
    Program::bind_texels(unit_probe, frame.lighting.octahedral_texels());
  }
  Program::bind_texture(unit_cones, frame.lighting.cone_texture());
  Program::bind_uniform_buffer(binding_lights, frame.lighting.light_buffer());
  Program::bind_uniform_buffer(binding_sh, frame.lighting.sh_buffer());
  return program;
}

/// The sets' turns and the directions, as SampleBlock has them.
Buffer sample_block(const ParameterSet& parameters) {
  const SampleSet samples = make_sample_set(int(parameters.integer("samples")),
                                            std::uint64_t(parameters.integer("seed")));
  std::vector<glm::vec4> block(samples.sets.begin(), samples.sets.end());
  block.insert(block.end(), samples.directions.begin(), samples.directions.end());
  return {block.data(), block.size() * sizeof(glm::vec4)};
}

/// Returns the unit after the last one.
GLuint bind_inputs(const Framebuffer& framebuffer) {
  GLuint unit = unit_input;
  for (const Texture& texture : framebuffer.colors()) Program::bind_texture(unit++, texture);
  return unit;
}

Image read_radiance(const Framebuffer& target) {
  return channels_of(target.colors().front().download(), 0, 3);
}

}  // namespace

MethodInfo screen_space_method(MethodInfo info, ScreenSpacePasses passes) {
  info.shaders = {passes.occlusion_shader, passes.lighting_shader, filter_shader};
  for (const std::string& shader :
       {passes.off_screen_shader, passes.direct_lighting_shader, passes.bounce_shader}) {
    if (!shader.empty()) info.shaders.push_back(shader);
  }
  info.representation = passes.representation;
  info.make = [passes = std::move(passes)] { return std::make_unique<ScreenSpaceMethod>(passes); };
  return info;
}

void ScreenSpaceMethod::prepare(const Frame& frame) {
  const View& view = frame.view;
  if (radiance_ && radiance_->colors().front().width() == view.width &&
      radiance_->colors().front().height() == view.height) {
    return;
  }
  representation_.emplace(view.width, view.height, passes_.representation_formats, false);
  if (!passes_.bounce_shader.empty()) {
    bounced_.emplace(view.width, view.height, passes_.representation_formats, false);
  }
  filtered_.emplace(view.width, view.height, passes_.representation_formats, false);
  const std::array<GLenum, 1> radiance_format = {GL_RGBA32F};
  radiance_.emplace(view.width, view.height, radiance_format, false);
}

void ScreenSpaceMethod::run_samples(const Frame& frame, const ParameterSet& parameters,
                                    const std::string& shader, const std::string& preamble,
                                    const Framebuffer& target, std::string_view pass) {
  const Buffer samples = sample_block(parameters);
  use_program(frame, parameters, shader, passes_, preamble);
  if (shader == passes_.bounce_shader) {
    const GLuint unit = bind_inputs(*representation_);
    Program::bind_texture(unit, radiance_->colors().front());
    if (hidden_settings(parameters)) Program::bind_texture(unit + 1, lit_hidden_->radiance);
  }
  Program::bind_uniform_buffer(binding_samples, samples);
  target.bind();
  frame.clock(pass, draw_fullscreen);
}

void ScreenSpaceMethod::run_occlusion(const Frame& frame, const ParameterSet& parameters) {
  if (!traces(parameters)) {
    const std::string preamble =
        passes_.occlusion_preamble ? passes_.occlusion_preamble(parameters) : std::string();
    run_samples(frame, parameters, passes_.occlusion_shader, preamble, *representation_,
                "occlusion");
    return;
  }
  frame.traced();  // built before the clock runs
  frame.clock("occlusion", [&] {
    const Representation& representation = *passes_.representation;
    representation.upload(occlusion_on_cpu(frame, parameters, representation), *representation_);
    if (const Bounce* bounce = representation.bounce) {
      bounce->upload(bounce_on_cpu(frame, parameters, *bounce, {}), *representation_);
    }
  });
}

ScreenSpaceMethod::LitHidden::LitHidden(const HiddenSurfaces& hidden,
                                        std::span<const GLenum> representation_formats)
    : representation(hidden.width(), hidden.height(), representation_formats, false),
      radiance(
          Texture::array(hidden.width(), hidden.height(), hidden.settings().count, GL_RGBA32F)) {
  const Texture* const array = &radiance;
  for (int i = 0; i < hidden.settings().count; ++i) {
    targets.emplace_back(std::span(&array, 1), i, nullptr);
  }
}

bool ScreenSpaceMethod::LitHidden::fits(const HiddenSurfaces& hidden) const {
  return radiance.width() == hidden.width() && radiance.height() == hidden.height() &&
         int(targets.size()) == hidden.settings().count;
}

/// The first pass over the hidden surfaces, each of them the receiver.
void ScreenSpaceMethod::light_hidden(const Frame& frame, const ParameterSet& parameters,
                                     const HiddenSettings& settings) {
  const HiddenSurfaces& hidden = frame.hidden(settings);
  if (!lit_hidden_ || !lit_hidden_->fits(hidden)) {
    lit_hidden_.emplace(hidden, passes_.representation_formats);
  }
  const Buffer samples = sample_block(parameters);
  const auto run = [&](const std::string& shader, int receiver) {
    use_program(frame, parameters, shader, passes_, "#define HIDDEN_RECEIVER\n")
        .set("receiver", receiver);
    Program::bind_uniform_buffer(binding_samples, samples);
    draw_fullscreen();
  };
  frame.clock("hidden_senders", [&] {
    for (int i = 0; i < settings.count; ++i) {
      lit_hidden_->representation.bind();
      run(passes_.occlusion_shader, i);
      bind_inputs(lit_hidden_->representation);
      lit_hidden_->targets[std::size_t(i)].bind();
      run(passes_.direct_lighting_shader, i);
    }
  });
}

void ScreenSpaceMethod::run_bounce(const Frame& frame, const ParameterSet& parameters) {
  if (const auto hidden = hidden_settings(parameters)) light_hidden(frame, parameters, *hidden);
  run_lighting(frame, parameters, passes_.direct_lighting_shader, *representation_, "senders");
  run_samples(frame, parameters, passes_.bounce_shader, {}, *bounced_, "bounce");
}

void ScreenSpaceMethod::run_filter(const Frame& frame, const ParameterSet& parameters,
                                   const Framebuffer& representation) {
  use_program(frame, parameters, filter_shader, passes_);
  bind_inputs(representation);
  filtered_->bind();
  frame.clock("filter", draw_fullscreen);
}

void ScreenSpaceMethod::run_lighting(const Frame& frame, const ParameterSet& parameters,
                                     const std::string& shader, const Framebuffer& representation,
                                     std::string_view pass) {
  use_program(frame, parameters, shader, passes_);
  bind_inputs(representation);
  radiance_->bind();
  frame.clock(pass, draw_fullscreen);
}

namespace {

/// Once more for every frame, as a renderer whose scene moves has to.
void draw_hidden(const Frame& frame, const ParameterSet& parameters) {
  const std::optional<HiddenSettings> settings = hidden_settings(parameters);
  if (!settings) return;
  const HiddenSurfaces& hidden = frame.hidden(*settings);
  const GBuffer& first = frame.gbuffer(settings->bits);
  frame.clock(settings->kind == HiddenKind::layers ? "layers" : "cameras", [&] {
    hidden.draw(frame.scene, frame.gpu_scene, frame.view, first, frame.programs);
  });
}

}  // namespace

void ScreenSpaceMethod::render(const Frame& frame, const ParameterSet& parameters) {
  prepare(frame);
  draw_hidden(frame, parameters);
  run_occlusion(frame, parameters);
  if (bounced_) run_bounce(frame, parameters);
  if (filters(parameters)) run_filter(frame, parameters, collected());
  run_lighting(frame, parameters, passes_.lighting_shader,
               filters(parameters) ? *filtered_ : collected());
  check_gl("a screen-space method");
}

Image ScreenSpaceMethod::lit(const Frame& frame, const ParameterSet& parameters,
                             const std::string& shader, const Framebuffer& representation) {
  run_lighting(frame, parameters, shader, representation);
  return read_radiance(*radiance_);
}

/// What the bounce adds: the radiance less that of the direct light alone.
void ScreenSpaceMethod::add_indirect(const Frame& frame, const ParameterSet& parameters,
                                     const Image& radiance, const Image& unfiltered,
                                     Layers& layers) {
  const std::string& shader = passes_.direct_lighting_shader;
  const Image direct = lit(frame, parameters, shader, *representation_);
  if (!filters(parameters)) {
    layers.add("radiance_indirect", difference(radiance, direct));
    return;
  }
  if (bounced_) run_filter(frame, parameters, *representation_);
  layers.add("radiance_indirect", difference(radiance, lit(frame, parameters, shader, *filtered_)));
  layers.add("radiance_indirect_unfiltered", difference(unfiltered, direct));
}

Layers ScreenSpaceMethod::evaluate(const Frame& frame, const ParameterSet& parameters,
                                   Metadata& facts) {
  render(frame, parameters);
  Layers layers;
  std::size_t negative_pixels = 0;
  const Image radiance = read_radiance(*radiance_);
  layers.add("radiance", clamp_negative(radiance, negative_pixels));
  facts["negative_pixels"] = std::to_string(negative_pixels);
  if (const auto hidden = hidden_settings(parameters)) add_hidden_facts(frame, *hidden, facts);
  if (passes_.add_facts && !traces(parameters)) passes_.add_facts(parameters, facts);
  const Representation& representation = *passes_.representation;
  const Framebuffer& shown = filters(parameters) ? *filtered_ : collected();
  representation.add_layers(representation.download(shown, representation.channels), layers);
  if (representation.bounce && representation.bounce->add_layers) {
    representation.bounce->add_layers(shown, parameters, layers);
  }
  Image unfiltered;
  if (filters(parameters)) {
    std::size_t negative_unfiltered = 0;
    unfiltered = lit(frame, parameters, passes_.lighting_shader, collected());
    layers.add("radiance_unfiltered", clamp_negative(unfiltered, negative_unfiltered));
    facts["negative_pixels_unfiltered"] = std::to_string(negative_unfiltered);
  }
  if (!passes_.direct_lighting_shader.empty()) {
    add_indirect(frame, parameters, radiance, unfiltered, layers);
  }
  if (!passes_.off_screen_shader.empty() && !traces(parameters)) {
    const std::array<GLenum, 1> format = {GL_R32F};
    const Framebuffer share(frame.view.width, frame.view.height, format, false);
    run_samples(frame, parameters, passes_.off_screen_shader, {}, share, "off_screen");
    layers.add("off_screen", channels_of(share.colors().front().download(), 0, 1));
  }
  check_gl("reading a screen-space method back");
  return layers;
}

}  // namespace occlab
