#include "renderers/gl/timer.h"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cmath>

#include "renderers/gl/context.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr double shortest_calibration_ms = 20.0;
constexpr double accepted_difference = 0.1;

void delete_query(GLuint id) { glDeleteQueries(1, &id); }

double wall_ms(const std::function<void()>& run) {
  glFinish();
  const auto start = std::chrono::steady_clock::now();
  run();
  glFinish();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

double query_ms(const std::function<void()>& run) {
  GLuint id = 0;
  glCreateQueries(GL_TIME_ELAPSED, 1, &id);
  const GlObject<delete_query> query(id);
  glFinish();
  glBeginQuery(GL_TIME_ELAPSED, id);
  run();
  glEndQuery(GL_TIME_ELAPSED);
  GLuint64 nanoseconds = 0;
  glGetQueryObjectui64v(id, GL_QUERY_RESULT, &nanoseconds);
  check_gl("a timer query");
  return double(nanoseconds) * 1e-6;
}

}  // namespace

std::string to_string(Clock clock) {
  return clock == Clock::gpu_query ? "GL_TIME_ELAPSED" : "wall clock around glFinish";
}

double time_ms(Clock clock, const std::function<void()>& run) {
  if (clock == Clock::wall) return wall_ms(run);
  double measured = 0.0;
  const double outside = wall_ms([&] { measured = query_ms(run); });
  if (!(measured > 0.0) || measured > outside) {
    throw DeviceError(fmt::format("GL_TIME_ELAPSED gave {:.3f} ms within {:.3f} ms of wall time",
                                  measured, outside));
  }
  return measured;
}

ClockCalibration calibrate_clock(ProgramCache& programs) {
  const std::array<GLenum, 1> format = {GL_RGBA32F};
  const Framebuffer target(256, 256, format, false);
  const Program& program =
      programs.get(fullscreen_vertex_shader, "renderers/gl/calibration.frag", "");
  program.use();
  target.bind();
  ClockCalibration calibration;
  int iterations = 64;
  program.set("iterations", iterations);
  wall_ms(draw_fullscreen);  // compiles
  while ((calibration.wall_ms = wall_ms(draw_fullscreen)) < shortest_calibration_ms &&
         iterations < (1 << 22)) {
    iterations *= 2;
    program.set("iterations", iterations);
  }
  double worst = 0.0;
  for (int repetition = 0; repetition < 3; ++repetition) {
    const double wall = wall_ms(draw_fullscreen);
    const double query = query_ms(draw_fullscreen);
    const double difference = query > 0.0 ? std::fabs(query - wall) / wall : 1.0;
    if (difference >= worst) {
      worst = difference;
      calibration.wall_ms = wall;
      calibration.query_ms = query;
    }
  }
  const bool believed = worst <= accepted_difference;
  calibration.clock = believed ? Clock::gpu_query : Clock::wall;
  calibration.verdict = fmt::format(
      "GL_TIME_ELAPSED says {:.2f} ms for a pass of {:.2f} ms of wall time: {}; times are by {}",
      calibration.query_ms, calibration.wall_ms, believed ? "believed" : "not believed",
      to_string(calibration.clock));
  return calibration;
}

}  // namespace occlab
