// Benchmarks of what a comparison's time goes into. Timings are for reading, never pass or fail:
//   build/release/tests/bench --benchmark_out=bench.json --benchmark_out_format=json
#include <benchmark/benchmark.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <random>

#include "harness/metrics/metrics.h"
#include "harness/workbench.h"
#include "renderers/scene/parallel.h"
#include "renderers/shared/frame.h"
#include "renderers/trace/reference.h"
#include "tests/unit/tiny_scenes.h"

namespace occlab {
namespace {

constexpr int width = 640;
constexpr int height = 360;
constexpr long rays_per_pixel = 64;
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

void trace(benchmark::State& state, Estimator estimator) {
  const Frame& frame = gallery().frame();
  const TracedScene& traced = frame.traced();
  const SurfacePoints points = surface_points();
  std::uint64_t rays = 0;
  for (auto _ : state) {
    const Reference reference = trace_reference(
        traced, frame.lighting.environment(), {}, frame.view, points,
        {.rays_per_pixel = rays_per_pixel, .estimator = estimator, .d_max_world = d_max_world});
    benchmark::DoNotOptimize(reference.radiance.values().data());
    rays += reference.rays;
  }
  state.counters["rays/s"] = benchmark::Counter(double(rays), benchmark::Counter::kIsRate);
}

void BM_reference_cosine(benchmark::State& state) { trace(state, Estimator::cosine); }
void BM_reference_mis(benchmark::State& state) { trace(state, Estimator::mis); }
BENCHMARK(BM_reference_cosine)->Unit(benchmark::kMillisecond)->UseRealTime()->MinTime(3);
BENCHMARK(BM_reference_mis)->Unit(benchmark::kMillisecond)->UseRealTime()->MinTime(3);

/// Rays from the reference's points with cosine-distributed directions, in its order: tile by tile,
/// sample by sample, pixel by pixel.
std::vector<std::vector<RTCRay>> rays_by_tile_row() {
  const Frame& frame = gallery().frame();
  const SurfacePoints points = surface_points();
  const glm::mat3 rotation = frame.view.world_from_view_rotation();
  const glm::vec3 eye(frame.view.camera.world_from_camera[3]);
  const float epsilon = 1e-4f * frame.traced().bounding_radius();
  const auto pixel = [](const Image& image, int x, int y) {
    return glm::vec3(image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2));
  };
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  std::vector<std::vector<RTCRay>> rows(height / 4);
  for (int tile_y = 0; tile_y < height / 4; ++tile_y) {
    for (int tile_x = 0; tile_x < width / 4; ++tile_x) {
      for (long sample = 0; sample < rays_per_pixel; ++sample) {
        const float u = uniform(random);
        const float angle = 2.0f * pi * uniform(random);
        const glm::vec3 local(std::sqrt(u) * std::cos(angle), std::sqrt(u) * std::sin(angle),
                              std::sqrt(1.0f - u));
        for (int lane = 0; lane < 16; ++lane) {
          const int x = tile_x * 4 + lane % 4;
          const int y = tile_y * 4 + lane / 4;
          if (points.mask.at(x, y) < 0.5f) continue;
          const glm::vec3 origin = eye + rotation * pixel(points.position_view, x, y) +
                                   epsilon * (rotation * pixel(points.geometric_normal_view, x, y));
          const glm::vec3 d = rotation * (tangent_frame(pixel(points.normal_view, x, y)) * local);
          RTCRay ray{};
          ray.org_x = origin.x;
          ray.org_y = origin.y;
          ray.org_z = origin.z;
          ray.dir_x = d.x;
          ray.dir_y = d.y;
          ray.dir_z = d.z;
          ray.tfar = d_max_world;
          ray.mask = ~0u;
          rows[std::size_t(tile_y)].push_back(ray);
        }
      }
    }
  }
  return rows;
}

/// The yardstick: rtcOccluded1 over ready-made rays on all threads, and nothing else.
void BM_bare_rtcOccluded1(benchmark::State& state) {
  const TracedScene& traced = gallery().frame().traced();
  const auto rows = rays_by_tile_row();
  std::uint64_t rays = 0;
  for (auto _ : state) {
    std::atomic<std::uint64_t> blocked{0};
    parallel_for(rows.size(), [&](std::size_t row) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      std::uint64_t count = 0;
      for (RTCRay ray : rows[row]) {
        rtcOccluded1(traced.handle(), &context, &ray);
        count += ray.tfar < 0.0f ? 1 : 0;
      }
      blocked += count;
    });
    benchmark::DoNotOptimize(blocked.load());
    for (const auto& row : rows) rays += row.size();
  }
  state.counters["rays/s"] = benchmark::Counter(double(rays), benchmark::Counter::kIsRate);
}
BENCHMARK(BM_bare_rtcOccluded1)->Unit(benchmark::kMillisecond)->UseRealTime()->MinTime(3);

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
