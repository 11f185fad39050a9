// The passes of the methods. Times are of a rasteriser that may be software; compare those of one
// run.
#include <benchmark/benchmark.h>

#include "renderers/gl/timer.h"
#include "renderers/methods/method.h"
#include "tests/bench/gallery.h"

namespace occlab::bench {
namespace {

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
  for ([[maybe_unused]] auto _ : state) {
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

}  // namespace
}  // namespace occlab::bench
