// Benchmarks of what a comparison's time goes into. Timings are for reading, never pass or fail:
//   build/release/tests/bench --benchmark_out=bench.json --benchmark_out_format=json
#include <benchmark/benchmark.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <optional>
#include <random>

#include "harness/metrics/metrics.h"
#include "harness/workbench.h"
#include "renderers/scene/parallel.h"
#include "renderers/shared/frame.h"
#include "renderers/trace/reference.h"
#include "tests/unit/tiny_scenes.h"

namespace occlab {
namespace {

// The frame of the S3HO study.
constexpr int width = 1280;
constexpr int height = 720;
constexpr float d_max_world = 0.5f;

Workbench& gallery() {
  static Workbench bench({.scene = "gallery",
                          .view = "main",
                          .width = width,
                          .height = height,
                          .probe = ProbeSettings{.source = "cathedral", .prefilter_degrees = 8.0f}},
                         "surfaceless");
  return bench;
}

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
  for (auto _ : state) {
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

glm::vec3 cosine_direction(std::mt19937& random) {
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  const float u = uniform(random);
  const float angle = 2.0f * pi * uniform(random);
  return {std::sqrt(u) * std::cos(angle), std::sqrt(u) * std::sin(angle), std::sqrt(1.0f - u)};
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
std::vector<RTCRay> naive_row(const SurfacePoints& points, int y) {
  std::mt19937 random{unsigned(y)};
  std::vector<RTCRay> rays;
  rays.reserve(std::size_t(width) * bare_rays_per_pixel);
  for (int x = 0; x < width; ++x) {
    const std::optional<BarePoint> point = bare_point(points, x, y);
    if (!point) continue;
    for (int i = 0; i < bare_rays_per_pixel; ++i) {
      rays.push_back(bare_ray(*point, cosine_direction(random)));
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
  for (auto _ : state) {
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
  parallel_for(rows.size(), [&](std::size_t y) { rows[y] = naive_row(points, int(y)); });
  trace_bare(state, rows);
}
BENCHMARK(BM_bare_rtcOccluded1)->Unit(benchmark::kMillisecond)->UseRealTime()->MinTime(3);

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
  for (auto _ : state) {
    std::atomic<std::uint64_t> blocked{0};
    parallel_for(height, [&](std::size_t y) {
      const std::vector<RTCRay> row = naive_row(points, int(y));
      blocked += count_blocked(traced, row);
      rays += row.size();
    });
    benchmark::DoNotOptimize(blocked.load());
  }
  state.counters["rays/s"] = benchmark::Counter(double(rays.load()), benchmark::Counter::kIsRate);
}
BENCHMARK(BM_bare_rtcOccluded1_and_rays)->Unit(benchmark::kMillisecond)->UseRealTime()->MinTime(3);

void BM_load_gallery(benchmark::State& state) {
  const std::filesystem::path path = gallery().scene().path;
  for (auto _ : state) benchmark::DoNotOptimize(load_scene(path).triangle_count());
  state.counters["triangles"] = double(gallery().scene().triangle_count());
}
BENCHMARK(BM_load_gallery)->Unit(benchmark::kMillisecond)->UseRealTime();

/// A grid of 500 x 500 cells, two triangles each, as a .glb.
void BM_load_500k_triangles(benchmark::State& state) {
  constexpr std::uint32_t side = 500;
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;
  std::vector<std::uint32_t> indices;
  for (std::uint32_t y = 0; y <= side; ++y) {
    for (std::uint32_t x = 0; x <= side; ++x) {
      positions.emplace_back(float(x), 0.0f, float(y));
      normals.emplace_back(0.0f, 1.0f, 0.0f);
      if (x == side || y == side) continue;
      const std::uint32_t corner = y * (side + 1) + x;
      for (const std::uint32_t offset : {0u, side + 1, 1u, 1u, side + 1, side + 2}) {
        indices.push_back(corner + offset);
      }
    }
  }
  test::TinyGltf gltf = test::tiny_triangle();
  auto& primitive = gltf.json["meshes"][0]["primitives"][0];
  primitive["attributes"] = {{"POSITION", gltf.add_vec3(positions)},
                             {"NORMAL", gltf.add_vec3(normals)}};
  primitive["indices"] = gltf.add_accessor(test::bytes_of(indices), 5125, "SCALAR", indices.size());
  const test::TemporaryFolder folder;
  const std::filesystem::path path = gltf.write(folder / "grid.glb");
  for (auto _ : state) {
    const Scene scene = load_scene(path);
    state.counters["triangles"] = double(scene.triangle_count());
  }
}
BENCHMARK(BM_load_500k_triangles)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_prefilter_cones(benchmark::State& state) {
  const Environment& environment = gallery().frame().lighting.environment();
  for (auto _ : state) {
    benchmark::DoNotOptimize(prefilter_cones(environment, cone_levels, cone_level_width));
  }
}
BENCHMARK(BM_prefilter_cones)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_project_sh(benchmark::State& state) {
  const Environment& environment = gallery().frame().lighting.environment();
  for (auto _ : state) benchmark::DoNotOptimize(project_sh(environment, glm::mat3(1.0f)));
}
BENCHMARK(BM_project_sh)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_metrics_1280x720(benchmark::State& state) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0.1f, 1.0f);
  const auto noise = [&](int channels) {
    Image image(1280, 720, channels);
    for (float& value : image.values()) value = uniform(random);
    return image;
  };
  const Image reference = noise(3);
  const Image test = noise(3);
  const Image occlusion = noise(1);
  const Image mask(1280, 720, 1, 1.0f);
  for (auto _ : state) {
    benchmark::DoNotOptimize(measure(
        {.reference = reference, .test = test, .mask = mask, .reference_occlusion = &occlusion}));
  }
}
BENCHMARK(BM_metrics_1280x720)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace occlab

BENCHMARK_MAIN();
