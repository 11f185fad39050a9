// Rays a second: the reference's, the converged runs', and those of bare loops to hold them
// against.
#include <benchmark/benchmark.h>

#include <atomic>
#include <cmath>
#include <optional>
#include <random>

#include "renderers/methods/cpu_passes.h"
#include "renderers/methods/method.h"
#include "renderers/scene/parallel.h"
#include "renderers/shared/frame.h"
#include "renderers/trace/reference.h"
#include "tests/bench/gallery.h"

namespace occlab::bench {
namespace {

SurfacePoints surface_points() {
  const GBufferImages& surface = gallery().frame().surface();
  return {surface.position_view, surface.normal_view, surface.geometric_normal_view, surface.albedo,
          surface.mask};
}

/// All of the reference: rays, probe look-ups and sums. The argument is the rays a pixel.
void trace(benchmark::State& state, Estimator estimator) {
  const Frame& frame = gallery().frame();
  const TracedScene& traced = frame.traced();
  const SurfacePoints points = surface_points();
  std::uint64_t rays = 0;
  for ([[maybe_unused]] auto _ : state) {
    const Reference reference = trace_reference(
        traced, frame.lighting.environment(), {}, frame.view, points,
        {.rays_per_pixel = state.range(0), .estimator = estimator, .d_max_world = d_max_world});
    benchmark::DoNotOptimize(reference.radiance.values().data());
    rays += reference.rays;
  }
  state.counters["rays/s"] = benchmark::Counter(double(rays), benchmark::Counter::kIsRate);
}

void BM_reference_cosine(benchmark::State& state) { trace(state, Estimator::cosine); }
void BM_reference_environment(benchmark::State& state) { trace(state, Estimator::environment); }
void BM_reference_mis(benchmark::State& state) { trace(state, Estimator::mis); }
BENCHMARK(BM_reference_cosine)->Arg(64)->Arg(512)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(BM_reference_environment)
    ->Arg(64)
    ->Arg(512)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(BM_reference_mis)->Arg(64)->Arg(512)->Unit(benchmark::kMillisecond)->UseRealTime();

/// The point of a pixel, world space.
struct BarePoint {
  glm::vec3 origin;
  glm::mat3 frame;
};

std::optional<BarePoint> bare_point(const SurfacePoints& points, int x, int y) {
  if (points.mask.at(x, y) < 0.5f) return std::nullopt;
  const Frame& frame = gallery().frame();
  const glm::mat3 rotation = frame.view.world_from_view_rotation();
  const glm::vec3 eye(frame.view.camera.world_from_camera[3]);
  const auto pixel = [&](const Image& image) {
    return glm::vec3(image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2));
  };
  return BarePoint{
      eye + rotation * pixel(points.position_view) +
          frame.traced().ray_lift_world() * (rotation * pixel(points.geometric_normal_view)),
      rotation * tangent_frame(pixel(points.normal_view))};
}

/// Tangent directions of density cos/pi, as the reference has them.
glm::vec3 cosine_direction(std::mt19937& random) {
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  const float u = uniform(random);
  const float angle = 2.0f * pi * uniform(random);
  return {std::sqrt(u) * std::cos(angle), std::sqrt(u) * std::sin(angle), std::sqrt(1.0f - u)};
}

/// Uniform over the hemisphere, as the screen-space methods have them: more of them graze.
glm::vec3 uniform_direction(std::mt19937& random) {
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  const float z = uniform(random);
  const float r = std::sqrt(1.0f - z * z);
  const float angle = 2.0f * pi * uniform(random);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

RTCRay bare_ray(const BarePoint& point, glm::vec3 direction_tangent) {
  const glm::vec3 d = point.frame * direction_tangent;
  RTCRay ray{};
  ray.org_x = point.origin.x;
  ray.org_y = point.origin.y;
  ray.org_z = point.origin.z;
  ray.dir_x = d.x;
  ray.dir_y = d.y;
  ray.dir_z = d.z;
  ray.tfar = d_max_world;
  ray.mask = ~0u;
  return ray;
}

// The yardsticks trace rays from the reference's points, cosine-distributed as its own. Their rate
// does not depend on how many there are for each pixel.
constexpr int bare_rays_per_pixel = 16;
using RayRows = std::vector<std::vector<RTCRay>>;

/// As one would write it first: pixel by pixel, every ray with its own random direction.
template <typename Direction>
std::vector<RTCRay> naive_row(const SurfacePoints& points, int y, const Direction& direction) {
  std::mt19937 random{unsigned(y)};
  std::vector<RTCRay> rays;
  rays.reserve(std::size_t(width) * bare_rays_per_pixel);
  for (int x = 0; x < width; ++x) {
    const std::optional<BarePoint> point = bare_point(points, x, y);
    if (!point) continue;
    for (int i = 0; i < bare_rays_per_pixel; ++i) {
      rays.push_back(bare_ray(*point, direction(random)));
    }
  }
  return rays;
}

/// In the reference's order, which is kinder to the caches: 4x4 pixels share their directions and
/// trace one after the other.
std::vector<RTCRay> tiled_row(const SurfacePoints& points, int tile_row) {
  std::mt19937 random{unsigned(tile_row)};
  std::vector<RTCRay> rays;
  for (int tile_x = 0; tile_x < width / 4; ++tile_x) {
    std::vector<BarePoint> tile;
    for (int lane = 0; lane < 16; ++lane) {
      const auto point = bare_point(points, tile_x * 4 + lane % 4, tile_row * 4 + lane / 4);
      if (point) tile.push_back(*point);
    }
    for (int i = 0; i < bare_rays_per_pixel; ++i) {
      const glm::vec3 direction = cosine_direction(random);
      for (const BarePoint& point : tile) rays.push_back(bare_ray(point, direction));
    }
  }
  return rays;
}

std::uint64_t count_blocked(const TracedScene& traced, const std::vector<RTCRay>& rays) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  std::uint64_t blocked = 0;
  for (RTCRay ray : rays) {
    rtcOccluded1(traced.handle(), &context, &ray);
    blocked += ray.tfar < 0.0f ? 1 : 0;
  }
  return blocked;
}

/// rtcOccluded1 over ready-made rays on all threads, and nothing else.
void trace_bare(benchmark::State& state, const RayRows& rows) {
  const TracedScene& traced = gallery().frame().traced();
  std::uint64_t rays = 0;
  for ([[maybe_unused]] auto _ : state) {
    std::atomic<std::uint64_t> blocked{0};
    parallel_for(rows.size(),
                 [&](std::size_t row) { blocked += count_blocked(traced, rows[row]); });
    benchmark::DoNotOptimize(blocked.load());
    for (const auto& row : rows) rays += row.size();
  }
  state.counters["rays/s"] = benchmark::Counter(double(rays), benchmark::Counter::kIsRate);
}

/// The bare rtcOccluded1 loop that the reference is held against.
void BM_bare_rtcOccluded1(benchmark::State& state) {
  const SurfacePoints points = surface_points();
  RayRows rows(height);
  parallel_for(rows.size(),
               [&](std::size_t y) { rows[y] = naive_row(points, int(y), cosine_direction); });
  trace_bare(state, rows);
}
BENCHMARK(BM_bare_rtcOccluded1)->Unit(benchmark::kMillisecond)->UseRealTime()->MinTime(3);

/// The one that the converged runs are held against.
void BM_bare_rtcOccluded1_uniform(benchmark::State& state) {
  const SurfacePoints points = surface_points();
  RayRows rows(height);
  parallel_for(rows.size(),
               [&](std::size_t y) { rows[y] = naive_row(points, int(y), uniform_direction); });
  trace_bare(state, rows);
}
BENCHMARK(BM_bare_rtcOccluded1_uniform)->Unit(benchmark::kMillisecond)->UseRealTime()->MinTime(3);

void BM_bare_rtcOccluded1_tile_order(benchmark::State& state) {
  const SurfacePoints points = surface_points();
  RayRows rows(height / 4);
  parallel_for(rows.size(), [&](std::size_t row) { rows[row] = tiled_row(points, int(row)); });
  trace_bare(state, rows);
}
BENCHMARK(BM_bare_rtcOccluded1_tile_order)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MinTime(3);

/// The bare loop with the making of its rays, as the reference makes its own.
void BM_bare_rtcOccluded1_and_rays(benchmark::State& state) {
  const TracedScene& traced = gallery().frame().traced();
  const SurfacePoints points = surface_points();
  std::atomic<std::uint64_t> rays{0};
  for ([[maybe_unused]] auto _ : state) {
    std::atomic<std::uint64_t> blocked{0};
    parallel_for(height, [&](std::size_t y) {
      const std::vector<RTCRay> row = naive_row(points, int(y), cosine_direction);
      blocked += count_blocked(traced, row);
      rays += row.size();
    });
    benchmark::DoNotOptimize(blocked.load());
  }
  state.counters["rays/s"] = benchmark::Counter(double(rays.load()), benchmark::Counter::kIsRate);
}
BENCHMARK(BM_bare_rtcOccluded1_and_rays)->Unit(benchmark::kMillisecond)->UseRealTime()->MinTime(3);

/// A round of a converged run, in two halves: visibility, look-ups where a method reads them, sums.
/// The argument is the rays a pixel of both halves.
void converge(benchmark::State& state, std::span<const char* const> names, bool traced) {
  const Frame& frame = gallery().frame();
  const GBufferImages& surface = frame.surface();
  ParameterSet parameters(find_method(names.front()).parameters);
  parameters.set("d_max_world", double(d_max_world));
  const PassConstants constants = pass_constants(parameters);
  const CpuLighting lighting(frame.lighting, constants);
  const DirectionPass pass{surface, lighting, constants,
                           traced ? traced_visibility(frame.traced(), frame.view, constants)
                                  : depth_visibility(surface, frame.view, constants)};
  std::vector<const Representation*> representations;
  std::array<std::vector<Image>, 2> sums;
  for (const char* name : names) {
    representations.push_back(find_method(name).representation);
    for (auto& half : sums) half.emplace_back(width, height, representations.back()->channels);
  }
  const std::array<SampleSet, 2> samples = {make_sample_set(int(state.range(0) / 2), 1),
                                            make_sample_set(int(state.range(0) / 2), 2)};
  const std::array<DirectionSums, 2> halves = {{{samples[0], sums[0]}, {samples[1], sums[1]}}};
  const auto pixels = double(std::ranges::count(surface.mask.values(), 1.0f));
  double rays = 0.0;
  for ([[maybe_unused]] auto _ : state) {
    add_directions(pass, halves, TurnPattern::tiles, representations);
    rays += pixels * double(state.range(0));
  }
  state.counters["rays/s"] = benchmark::Counter(rays, benchmark::Counter::kIsRate);
}

constexpr std::array<const char*, 4> all_methods = {"ssao", "s3ho", "ssdo", "ssbn"};

/// One method at a time, by its place in all_methods.
template <std::size_t method>
void BM_converged(benchmark::State& state) {
  state.SetLabel(all_methods[method]);
  converge(state, std::span(all_methods).subspan(method, 1), true);
}
BENCHMARK(BM_converged<0>)->Arg(512)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(BM_converged<1>)->Arg(512)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(BM_converged<2>)->Arg(512)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(BM_converged<3>)->Arg(512)->Unit(benchmark::kMillisecond)->UseRealTime();

/// All of them along the same rays, as the error budget runs them.
void BM_converged_together(benchmark::State& state) { converge(state, all_methods, true); }
BENCHMARK(BM_converged_together)->Arg(128)->Arg(512)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_converged_march(benchmark::State& state) { converge(state, all_methods, false); }
BENCHMARK(BM_converged_march)->Arg(128)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace occlab::bench
