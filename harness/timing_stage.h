#pragma once

#include <optional>
#include <vector>

#include "harness/config.h"
#include "harness/timing_loop.h"
#include "harness/workbench.h"

namespace occlab {

/// A workbench's scene with so many triangles, ready to be drawn at any resolution. The scene as it
/// is is drawn with the workbench's own frame, which is as it was when the stage is gone.
class TimingStage {
 public:
  /// `triangles` as in TimedCell. Throws InputError where the scene has more.
  TimingStage(Workbench& bench, long triangles);
  ~TimingStage();
  TimingStage(const TimingStage&) = delete;
  TimingStage& operator=(const TimingStage&) = delete;

  std::size_t triangles() const { return frame_->scene.triangle_count(); }  ///< that there are

  /// One frame: the G-buffer's pass, `gbuffer`, then the method's own.
  FrameTimes run(OcclusionMethod& method, const ParameterSet& parameters, Resolution resolution,
                 Clock clock);

 private:
  struct Size {
    Resolution resolution;
    Frame::Made made;  ///< while another resolution is in use
  };
  void use(Resolution resolution);

  std::optional<Scene> split_;
  std::optional<GpuScene> split_on_gpu_;
  std::optional<Frame> split_frame_;
  Frame* frame_;  ///< split_frame_, or the workbench's
  std::vector<Size> sizes_;
  std::size_t in_use_ = 0;
};

}  // namespace occlab
