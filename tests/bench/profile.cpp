// Where the occlusion passes' time goes: SSAO as one would write it first, and S3HO and SSDO with
// parts of their work taken out, down to what is left over SSAO when they only write their output.
// What a part costs is the difference of two of these.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "renderers/gl/timer.h"
#include "renderers/methods/sample_set.h"
#include "renderers/methods/sample_shader.h"
#include "tests/bench/gallery.h"

namespace occlab::bench {
namespace {

constexpr int steps = 2;

struct Variant {
  const char* shader;
  std::vector<GLenum> targets;
  bool samples_in_buffer = false;
  int probe_side = 1;  ///< the map is read as if it had so many texels across
  std::vector<std::pair<std::string, std::string>> replacements;
};

/// A replacement that finds nothing would time the whole shader under the name of its part.
void replace(std::string& text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("the shader has no '" + from + "'");
  text.replace(at, from.size(), to);
}

Program compiled(const Variant& variant, const ParameterSet& parameters, int samples) {
  const std::string preamble =
      parameters.glsl_preamble() +
      (variant.samples_in_buffer ? "#define SAMPLES_IN_BUFFER\n"
                                 : sample_constants(samples, steps)) +
      fmt::format("#define LIGHT_COUNT 0\n#define PROBE_SIDE {}\n#define PROJECTS_BITS\n",
                  variant.probe_side) +
      sh_projection(samples);
  ShaderSource fragment = expand_shader(variant.shader, preamble);
  for (const auto& [from, to] : variant.replacements) replace(fragment.text, from, to);
  return Program(expand_shader(fullscreen_vertex_shader, preamble), fragment);
}

/// Compiling takes longer than timing.
const Program& program_of(const std::string& name, const Variant& variant,
                          const ParameterSet& parameters, int samples) {
  static std::map<std::pair<std::string, int>, Program> programs;
  const auto key = std::pair(name, samples);
  const auto found = programs.find(key);
  if (found != programs.end()) return found->second;
  return programs.emplace(key, compiled(variant, parameters, samples)).first->second;
}

void profile_pass(benchmark::State& state, const char* name, const Variant& variant) {
  const Frame& frame = gallery().frame();
  const int samples = int(state.range(0));
  const ParameterSet parameters = study_parameters("ssao", samples);
  const Program& program = program_of(name, variant, parameters, samples);
  const SampleSet set = make_sample_set(samples, 0);
  std::vector<glm::vec4> block(set.sets.begin(), set.sets.end());
  block.insert(block.end(), set.directions.begin(), set.directions.end());
  const Buffer buffer(block.data(), block.size() * sizeof(glm::vec4));
  const Framebuffer target(width, height, variant.targets, false);
  const GBuffer& gbuffer = frame.gbuffer(GBufferBits::float32);
  program.use();
  for (const Parameter& parameter : parameters.declared()) {
    if (parameter.kind != ParameterKind::real) continue;
    program.set(parameter.name.c_str(), parameters.real32(parameter.name));
  }
  program.set("focal_pixels", frame.view.focal_pixels());
  program.set("image_center", 0.5f * glm::vec2(width, height));
  program.set("probe_from_view", frame.lighting.probe_from_view());
  Program::bind_texture(0, gbuffer.position_view());
  Program::bind_texture(1, gbuffer.normal_view());
  Program::bind_texels(3, frame.lighting.octahedral_texels());
  Program::bind_uniform_buffer(0, buffer);
  target.bind();
  time_pass(Clock::wall, draw_fullscreen);  // compiles
  for ([[maybe_unused]] auto _ : state) {
    state.SetIterationTime(1e-3 * time_pass(Clock::wall, draw_fullscreen).wall_ms);
  }
}

const char* const ssao_shader = "renderers/methods/ssao.frag";
const char* const s3ho_shader = "renderers/methods/s3ho.frag";
const char* const ssdo_shader = "renderers/methods/ssdo.frag";

Variant ssao() { return {ssao_shader, {GL_R32F}, false, 1, {}}; }
Variant plain_ssao() { return {ssao_shader, {GL_R32F}, true, 1, {}}; }
Variant s3ho() { return {s3ho_shader, {GL_RGBA32UI, GL_RGBA32UI}, false, 1, {}}; }

Variant s3ho_without_rotation() {
  Variant variant = s3ho();
  variant.replacements.emplace_back("return sh_rotate(c, frame);", "return c;");
  return variant;
}

Variant s3ho_without_products() {
  Variant variant = s3ho_without_rotation();
  variant.replacements.emplace_back("project_visibility(visible, c.c0, c.c1, c.c2, c.c3);",
                                    "c.c0 = c.c1 = c.c2 = c.c3 = vec4(float(visible[0]));");
  return variant;
}

Variant s3ho_write_only() {
  Variant variant = s3ho_without_products();
  variant.replacements.emplace_back("out_low = sh_pack_low(c);",
                                    "out_low = floatBitsToUint(c.c0);");
  variant.replacements.emplace_back("out_high = sh_pack_high(c);",
                                    "out_high = floatBitsToUint(c.c2);");
  return variant;
}

/// The bits alone, as many bytes as SSAO writes.
Variant s3ho_bits_only() {
  Variant variant = s3ho();
  variant.targets = {GL_R32UI};
  variant.replacements = {{"out uvec4 out_low", "out uint out_low"},
                          {"layout(location = 1) out uvec4 out_high;", ""},
                          {"out_low = uvec4(0u);", "out_low = 0u;"},
                          {"out_high = uvec4(0u);", ""},
                          {"return sh_rotate(c, frame);", "return c;"},
                          {"project_visibility(visible, c.c0, c.c1, c.c2, c.c3);",
                           "c.c0 = uintBitsToFloat(uvec4(visible[0]));"},
                          {"out_low = sh_pack_low(c);", "out_low = floatBitsToUint(c.c0.x);"},
                          {"out_high = sh_pack_high(c);", ""}};
  return variant;
}

Variant ssdo_of(int probe_side) { return {ssdo_shader, {GL_RGBA32F}, false, probe_side, {}}; }

/// The map's coordinates without what is there.
Variant ssdo_without_fetch() {
  Variant variant = ssdo_of(256);
  variant.replacements.emplace_back(
      "texelFetch(octahedral_probe, texel.y * PROBE_SIDE + texel.x).xy", "uvec2(texel << 16)");
  return variant;
}

#define PROFILE(name, variant)                          \
  BENCHMARK_CAPTURE(profile_pass, name, #name, variant) \
      ->Arg(32)                                         \
      ->Arg(16)                                         \
      ->Arg(8)                                          \
      ->Unit(benchmark::kMillisecond)                   \
      ->UseManualTime()
PROFILE(ssao_plain, plain_ssao());
PROFILE(ssao, ssao());
PROFILE(s3ho_bits_only, s3ho_bits_only());
PROFILE(s3ho_write_only, s3ho_write_only());
PROFILE(s3ho_without_products, s3ho_without_products());
PROFILE(s3ho_without_rotation, s3ho_without_rotation());
PROFILE(s3ho, s3ho());
PROFILE(ssdo_without_fetch, ssdo_without_fetch());
PROFILE(ssdo_map_16, ssdo_of(16));
PROFILE(ssdo_map_64, ssdo_of(64));
PROFILE(ssdo, ssdo_of(gallery().frame().lighting.octahedral_probe().width()));

}  // namespace
}  // namespace occlab::bench
