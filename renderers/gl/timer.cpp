#include "renderers/gl/timer.h"

#include <fmt/format.h>

#include <array>
#include <cassert>
#include <chrono>
#include <cmath>

#include "renderers/gl/context.h"

namespace occlab {
namespace {

constexpr double shortest_calibration_ms = 20.0;
constexpr int calibration_passes = 3;
constexpr double accepted_difference = 0.1;
constexpr double long_pass_ms = 10.0;
constexpr double least_share_of_long_pass = 0.5;

void delete_query(GLuint id) { glDeleteQueries(1, &id); }

double wall_ms(const std::function<void()>& run) {
  glFinish();
  const auto start = std::chrono::steady_clock::now();
  run();
  glFinish();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

double milliseconds(const QueryReading& reading) { return double(reading.nanoseconds) * 1e-6; }

/// How far apart the clocks are, relative to the wall clock; rejected readings are further apart
/// than any other.
double difference(const ClockComparison& comparison) {
  if (!why_rejected(comparison.query, comparison.wall_ms).empty()) return HUGE_VAL;
  return std::fabs(milliseconds(comparison.query) - comparison.wall_ms) / comparison.wall_ms;
}

ClockComparison compare_clocks(const std::function<void()>& run) {
  ClockComparison comparison;
  GLint bits = 0;
  glGetQueryiv(GL_TIME_ELAPSED, GL_QUERY_COUNTER_BITS, &bits);
  comparison.query.counter_bits = bits;
  GLuint id = 0;
  glCreateQueries(GL_TIME_ELAPSED, 1, &id);
  const GlObject<delete_query> query(id);
  comparison.wall_ms = wall_ms([&] {
    glBeginQuery(GL_TIME_ELAPSED, id);
    run();
    glEndQuery(GL_TIME_ELAPSED);
  });
  GLint64 nanoseconds = 0;
  glGetQueryObjecti64v(id, GL_QUERY_RESULT, &nanoseconds);
  check_gl("a timer query");
  comparison.query.nanoseconds = nanoseconds;
  return comparison;
}

}  // namespace

std::string to_string(Clock clock) {
  return clock == Clock::gpu_query ? "GL_TIME_ELAPSED" : "wall clock around glFinish";
}

std::string why_rejected(const QueryReading& reading, double wall_ms) {
  const double ms = milliseconds(reading);
  const auto says = [&](const char* what) {
    return fmt::format("GL_TIME_ELAPSED says {:g} ms for {:g} ms of wall time: {}", ms, wall_ms,
                       what);
  };
  if (reading.counter_bits <= 0) return says("the device has no counter");
  if (reading.nanoseconds < 0) return says("negative");
  if (reading.nanoseconds == 0) return says("zero");
  if (wall_ms * 1e6 >= std::exp2(reading.counter_bits)) {
    return says("its counter may have started again");
  }
  if (!(ms <= wall_ms)) return says("longer than the wall time around it");
  if (wall_ms > long_pass_ms && ms < least_share_of_long_pass * wall_ms) {
    return says("less than half");
  }
  return "";
}

PassTime time_pass(Clock clock, const std::function<void()>& run) {
  PassTime time;
  if (clock == Clock::wall) {
    time.wall_ms = wall_ms(run);
    time.ms = time.wall_ms;
    return time;
  }
  const ClockComparison comparison = compare_clocks(run);
  time.wall_ms = comparison.wall_ms;
  time.rejected = why_rejected(comparison.query, comparison.wall_ms);
  if (time.rejected.empty()) time.ms = milliseconds(comparison.query);
  return time;
}

ClockCalibration judge_clocks(const std::vector<ClockComparison>& comparisons, bool software) {
  assert(!comparisons.empty());
  const ClockComparison* worst = &comparisons.front();
  for (const ClockComparison& comparison : comparisons) {
    if (difference(comparison) > difference(*worst)) worst = &comparison;
  }
  const bool believed = !software && difference(*worst) <= accepted_difference;
  ClockCalibration calibration{believed ? Clock::gpu_query : Clock::wall,
                               milliseconds(worst->query), worst->wall_ms, ""};
  const std::string rejected = why_rejected(worst->query, worst->wall_ms);
  calibration.verdict = fmt::format(
      "{}: {}; times are by {}",
      rejected.empty() ? fmt::format("GL_TIME_ELAPSED says {:.2f} ms for a pass of {:.2f} ms of "
                                     "wall time",
                                     calibration.query_ms, calibration.wall_ms)
                       : rejected,
      believed   ? "believed"
      : software ? "not believed of a software rasteriser"
                 : "not believed",
      to_string(calibration.clock));
  return calibration;
}

ClockCalibration calibrate_clock(ProgramCache& programs, bool software) {
  const std::array<GLenum, 1> format = {GL_RGBA32F};
  const Framebuffer target(256, 256, format, false);
  const Program& program =
      programs.get(fullscreen_vertex_shader, "renderers/gl/calibration.frag", "");
  program.use();
  target.bind();
  int iterations = 64;
  program.set("iterations", iterations);
  wall_ms(draw_fullscreen);  // compiles
  while (wall_ms(draw_fullscreen) < shortest_calibration_ms && iterations < (1 << 22)) {
    iterations *= 2;
    program.set("iterations", iterations);
  }
  std::vector<ClockComparison> comparisons;
  for (int i = 0; i < calibration_passes; ++i) {
    comparisons.push_back(compare_clocks(draw_fullscreen));
  }
  return judge_clocks(comparisons, software);
}

}  // namespace occlab
