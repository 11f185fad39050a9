// What the harness itself costs: the cell store.
#include <benchmark/benchmark.h>

#include <optional>

#include "harness/cells.h"
#include "harness/store.h"
#include "tests/bench/gallery.h"
#include "tests/unit/tiny_scenes.h"

namespace occlab::bench {
namespace {

/// A cell of the study: S3HO with all its layers at 1280x720.
struct StoredExample {
  CellKey key;
  Layers layers;
};

const StoredExample& example() {
  static const StoredExample made = [] {
    PlannedCell cell{Role::test, "s3ho", ParameterSet(find_method("s3ho").parameters), 0};
    const auto method = find_method("s3ho").make();
    Metadata facts;
    Layers layers = render_cell(gallery(), cell, *method, facts);
    return StoredExample{cell_key(gallery(), cell), std::move(layers)};
  }();
  return made;
}

/// Writing under a temporary name, syncing and renaming.
void BM_cell_store_write(benchmark::State& state) {
  const StoredExample& cell = example();
  std::optional<TemporaryFolder> folder;
  for ([[maybe_unused]] auto _ : state) {
    state.PauseTiming();
    folder.emplace();
    CellStore store(*folder / "results");
    state.ResumeTiming();
    store.write(cell.key, cell.layers, {});
  }
}
BENCHMARK(BM_cell_store_write)->Unit(benchmark::kMillisecond)->UseRealTime();

/// Reading and checking what was written.
void BM_cell_store_read(benchmark::State& state) {
  const StoredExample& cell = example();
  const TemporaryFolder folder;
  CellStore store(folder / "results");
  store.write(cell.key, cell.layers, {});
  for ([[maybe_unused]] auto _ : state) {
    const ReadCell read = store.read(cell.key);
    if (!read.cell) state.SkipWithError(read.warning.c_str());
  }
}
BENCHMARK(BM_cell_store_read)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace occlab::bench
