// The passes of the methods, and the plainest SSAO to hold them against: S3HO is not to be cheap by
// way of a slow SSAO. Times are of a rasteriser that may be software; compare those of one run.
#include <benchmark/benchmark.h>

#include "renderers/gl/timer.h"
#include "renderers/methods/method.h"
#include "renderers/methods/pass_constants.h"
#include "renderers/methods/sample_set.h"
#include "tests/bench/gallery.h"

namespace occlab::bench {
namespace {

ParameterSet study_parameters(const std::string& method, long samples) {
  ParameterSet parameters(find_method(method).parameters);
  parameters.set("samples", samples);
  parameters.set("d_max_world", double(d_max_world));
  return parameters;
}

/// One pass of a method's frame, as occlab times it: wall clock around glFinish.
void time_pass_of(benchmark::State& state, const std::string& name, const ParameterSet& parameters,
                  std::string_view pass) {
  Frame& frame = gallery().frame();
  const auto method = find_method(name).make();
  method->render(frame, parameters);  // compiles
  double seconds = 0.0;
  frame.clock = [&](std::string_view running, const std::function<void()>& run) {
    const PassTime time = time_pass(Clock::wall, run);
    if (running == pass) seconds = 1e-3 * time.wall_ms;
  };
  for (auto _ : state) {
    method->render(frame, parameters);
    state.SetIterationTime(seconds);
  }
  frame.clock = [](std::string_view, const std::function<void()>& run) { run(); };
}

void BM_filter_pass(benchmark::State& state, const char* method) {
  time_pass_of(state, method, study_parameters(method, 8), "filter");
}
BENCHMARK_CAPTURE(BM_filter_pass, ssao, "ssao")->Unit(benchmark::kMillisecond)->UseManualTime();
BENCHMARK_CAPTURE(BM_filter_pass, s3ho, "s3ho")->Unit(benchmark::kMillisecond)->UseManualTime();

/// The argument is N.
void BM_occlusion_pass(benchmark::State& state, const char* method) {
  time_pass_of(state, method, study_parameters(method, state.range(0)), "occlusion");
}
#define OCCLUSION_PASS(method)                          \
  BENCHMARK_CAPTURE(BM_occlusion_pass, method, #method) \
      ->Arg(32)                                         \
      ->Arg(16)                                         \
      ->Arg(8)                                          \
      ->Unit(benchmark::kMillisecond)                   \
      ->UseManualTime()
OCCLUSION_PASS(ssao);
OCCLUSION_PASS(s3ho);
OCCLUSION_PASS(ssdo);
OCCLUSION_PASS(ssbn);

/// S3HO as the paper has it: basis functions for every direction.
void BM_occlusion_pass_s3ho_direct(benchmark::State& state) {
  ParameterSet parameters = study_parameters("s3ho", state.range(0));
  parameters.set("projection", "direct");
  time_pass_of(state, "s3ho", parameters, "occlusion");
}
BENCHMARK(BM_occlusion_pass_s3ho_direct)
    ->Arg(32)
    ->Arg(16)
    ->Arg(8)
    ->Unit(benchmark::kMillisecond)
    ->UseManualTime();

/// SSAO with its samples read from a uniform buffer in a loop, as one would write it first.
void BM_plain_ssao(benchmark::State& state) {
  const Frame& frame = gallery().frame();
  const ParameterSet parameters = study_parameters("ssao", state.range(0));
  const SampleSet samples = make_sample_set(int(state.range(0)), 0);
  std::vector<glm::vec4> block(samples.sets.begin(), samples.sets.end());
  block.insert(block.end(), samples.directions.begin(), samples.directions.end());
  const Buffer buffer(block.data(), block.size() * sizeof(glm::vec4));
  const GBuffer& gbuffer = frame.gbuffer(GBufferBits::float32);
  const Program program(fullscreen_vertex_shader, "renderers/methods/ssao.frag",
                        parameters.glsl_preamble() +
                            "#define SAMPLES_IN_BUFFER\n#define PROBE_SIDE 1\n"
                            "#define LIGHT_COUNT 0\n");
  const std::array<GLenum, 1> format = {GL_R32F};
  const Framebuffer target(width, height, format, false);
  program.use();
  for (const Parameter& parameter : parameters.declared()) {
    if (parameter.kind != ParameterKind::real) continue;
    program.set(parameter.name.c_str(), parameters.real32(parameter.name));
  }
  program.set("focal_pixels", frame.view.focal_pixels());
  program.set("image_center", 0.5f * glm::vec2(width, height));
  Program::bind_texture(0, gbuffer.position_view());
  Program::bind_texture(1, gbuffer.normal_view());
  Program::bind_uniform_buffer(0, buffer);
  target.bind();
  time_pass(Clock::wall, draw_fullscreen);  // compiles
  for (auto _ : state) {
    state.SetIterationTime(1e-3 * time_pass(Clock::wall, draw_fullscreen).wall_ms);
  }
}
BENCHMARK(BM_plain_ssao)->Arg(32)->Arg(16)->Arg(8)->Unit(benchmark::kMillisecond)->UseManualTime();

}  // namespace
}  // namespace occlab::bench
