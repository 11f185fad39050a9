// Benchmarks of what a comparison's time goes into. Timings are for reading, never pass or fail:
//   build/release/tests/bench --benchmark_out=bench.json --benchmark_out_format=json
#include <benchmark/benchmark.h>

#include <filesystem>
#include <random>

#include "harness/metrics/metrics.h"
#include "tests/bench/gallery.h"
#include "tests/unit/tiny_scenes.h"

namespace occlab::bench {
namespace {

void BM_load_gallery(benchmark::State& state) {
  const std::filesystem::path path = gallery().scene().path;
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(load_scene(path).triangle_count());
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
  const TemporaryFolder folder;
  const std::filesystem::path path = gltf.write(folder / "grid.glb");
  for ([[maybe_unused]] auto _ : state) {
    const Scene scene = load_scene(path);
    state.counters["triangles"] = double(scene.triangle_count());
  }
}
BENCHMARK(BM_load_500k_triangles)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_prefilter_cones(benchmark::State& state) {
  const Environment& environment = gallery().frame().lighting.environment();
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(prefilter_cones(environment, cone_levels, cone_level_width));
  }
}
BENCHMARK(BM_prefilter_cones)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_project_sh(benchmark::State& state) {
  const Environment& environment = gallery().frame().lighting.environment();
  for ([[maybe_unused]] auto _ : state)
    benchmark::DoNotOptimize(project_sh(environment, glm::mat3(1.0f)));
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
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(measure(
        {.reference = reference, .test = test, .mask = mask, .reference_occlusion = &occlusion}));
  }
}
BENCHMARK(BM_metrics_1280x720)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace occlab::bench

BENCHMARK_MAIN();
