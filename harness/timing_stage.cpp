#include "harness/timing_stage.h"

#include <algorithm>

#include "harness/split_triangles.h"

namespace occlab {
namespace {

GBufferBits bits_of(const ParameterSet& parameters) {
  return parameters.has("gbuffer_bits") && parameters.choice("gbuffer_bits") == "16"
             ? GBufferBits::float16
             : GBufferBits::float32;
}

}  // namespace

TimingStage::TimingStage(Workbench& bench, long triangles) : frame_(&bench.frame()) {
  if (triangles > 0) {
    const int parts = split_factor(bench.scene().triangle_count(), std::size_t(triangles));
    split_.emplace(split_triangles(bench.scene(), parts));
    split_on_gpu_.emplace(*split_);
    const Frame& whole = bench.frame();
    split_frame_.emplace(Frame{
        .scene = *split_,
        .gpu_scene = *split_on_gpu_,
        .view = whole.view,
        .lighting = Lighting(whole.lighting.environment(), whole.lighting.lights(), whole.view),
        .programs = whole.programs});
    frame_ = &*split_frame_;
  }
  sizes_.push_back({{frame_->view.width, frame_->view.height}, {}});
}

TimingStage::~TimingStage() { use(sizes_.front().resolution); }

void TimingStage::use(Resolution resolution) {
  auto wanted = std::ranges::find(sizes_, resolution, &Size::resolution);
  if (wanted == sizes_.end()) wanted = sizes_.insert(wanted, {resolution, {}});
  const auto index = std::size_t(wanted - sizes_.begin());
  std::swap(sizes_[in_use_].made, frame_->made);
  std::swap(sizes_[index].made, frame_->made);
  frame_->view.width = resolution.width;
  frame_->view.height = resolution.height;
  in_use_ = index;
}

FrameTimes TimingStage::run(OcclusionMethod& method, const ParameterSet& parameters,
                            Resolution resolution, Clock clock) {
  use(resolution);
  FrameTimes times;
  const auto timed = [&](std::string_view pass, const std::function<void()>& run) {
    times.passes.emplace_back(pass, time_pass(clock, run));
  };
  const Framebuffer& targets = frame_->gbuffer(bits_of(parameters)).targets;
  const PassClock plain = std::exchange(frame_->clock, timed);
  times.wall_ms =
      time_pass(Clock::wall, [&] {
        timed("gbuffer", [&] {
          draw_gbuffer(targets, frame_->scene, frame_->gpu_scene, frame_->view, frame_->programs);
        });
        method.render(*frame_, parameters);
      }).wall_ms;
  frame_->clock = plain;
  return times;
}

}  // namespace occlab
