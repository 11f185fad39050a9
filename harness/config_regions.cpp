// What config_parts.h has of parts of the frame.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "harness/config_parts.h"

namespace occlab {
namespace {

void add_region(const TomlTable& table, const std::string& key, const Region& region,
                BenchSettings& bench) {
  const auto known = std::ranges::find(bench.regions, region.name, &Region::name);
  if (known == bench.regions.end()) {
    bench.regions.push_back(region);
  } else if (*known != region) {
    table.fail(key, fmt::format("two different parts of the frame are called '{}'", region.name));
  }
}

Region region_of(const FigurePoint& point) { return {point.label, {point.x, point.y, 1, 1}, true}; }

}  // namespace

Rectangle read_rectangle(TomlTable& table, const SceneSettings& scene) {
  const TomlTable::Numbers numbers = table.numbers("rectangle", 4);
  std::vector<double> r = numbers.values;
  if (!numbers.whole) {
    for (std::size_t i = 0; i < 4; ++i) {
      if (!(r[i] >= 0 && r[i] <= 1)) {
        table.fail("rectangle",
                   "accepted are four integers (pixels) or four reals in [0, 1] "
                   "(fractions of the frame)");
      }
    }
    // The corners are rounded, not the sizes, so that rectangles that touch still do.
    const auto pixel = [](double fraction, int size) { return std::round(fraction * size); };
    const double right = pixel(r[0] + r[2], scene.width);
    const double bottom = pixel(r[1] + r[3], scene.height);
    r[0] = pixel(r[0], scene.width);
    r[1] = pixel(r[1], scene.height);
    r[2] = right - r[0];
    r[3] = bottom - r[1];
  }
  if (r[0] < 0 || r[1] < 0 || r[2] < 1 || r[3] < 1 || r[0] + r[2] > scene.width ||
      r[1] + r[3] > scene.height) {
    table.fail(
        "rectangle",
        fmt::format("x {:g}, y {:g}, width {:g}, height {:g} (pixels) is empty or not inside "
                    "the frame of {}x{}",
                    r[0], r[1], r[2], r[3], scene.width, scene.height));
  }
  return {int(r[0]), int(r[1]), int(r[2]), int(r[3])};
}

FigurePoint read_point(TomlTable& table, const SceneSettings& scene) {
  FigurePoint point;
  point.label = table.text("label");
  const TomlTable::Numbers numbers = table.numbers("pixel", 2);
  const double x = numbers.whole ? numbers.values[0] : numbers.values[0] * scene.width;
  const double y = numbers.whole ? numbers.values[1] : numbers.values[1] * scene.height;
  if (!(x >= 0 && x < scene.width && y >= 0 && y < scene.height)) {
    table.fail("pixel", fmt::format("found a place outside of the frame of {}x{}; accepted are two "
                                    "integers (a pixel) or two reals in [0, 1) (fractions)",
                                    scene.width, scene.height));
  }
  point.x = int(x);
  point.y = int(y);
  return point;
}

void read_region(TomlTable& table, std::vector<BenchSettings>& benches) {
  const std::size_t place = select_bench(table, "label", benches, read_bench_values(table));
  BenchSettings& bench = benches[place];
  if (table.has("rectangle") == table.has("pixel")) {
    table.fail("label", "accepted is a rectangle or a pixel, one of both");
  }
  if (table.has("pixel")) {
    add_region(table, "label", region_of(read_point(table, bench.scene)), bench);
  } else {
    const std::string label = table.text("label");
    add_region(table, "label", {label, read_rectangle(table, bench.scene)}, bench);
  }
  table.refuse_others();
}

void add_regions(const TomlTable& table, const FigureSettings& figure,
                 std::vector<BenchSettings>& benches) {
  for (const CloseupRow& row : figure.rows) {
    add_region(table, "rows", {row.label, row.rectangle}, benches[figure.bench]);
  }
  for (const FigurePoint& point : figure.points) {
    add_region(table, "points", region_of(point), benches[figure.bench]);
  }
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    const GridEntry& row = figure.grid_rows[i / figure.columns.size()];
    if (!row.rectangle) continue;
    add_region(table, "rows", {row.label, *row.rectangle}, benches[figure.panels[i].bench]);
  }
}

}  // namespace occlab
