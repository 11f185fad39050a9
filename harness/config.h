#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "harness/grid.h"
#include "renderers/methods/method.h"
#include "renderers/scene/environment.h"
#include "renderers/scene/error.h"

namespace occlab {

// The experiment file; configs/FORMAT.md describes every key.

/// An experiment has its cells in memory, at some 5 KB each: the plan, its keys and what is
/// compared in the end.
inline constexpr long most_cells = 100'000;

struct SceneSettings {
  std::string source;  ///< a scene's name, or the absolute path of a .glb or .gltf
  std::string view;    ///< a camera's name; empty: the first
  int width = 1280;    ///< pixels
  int height = 720;
};

struct ReferenceSettings {
  std::string method;
  /// Further truths, with the same parameters: every method is compared with its own
  /// (MethodInfo::truth). Empty: all with `method`.
  std::vector<std::string> others = {};
  NamedValues parameters;
  double tolerance = 0.1;  ///< of the smallest error (certification.h)
  /// As many rays as it may take to get there; none: `rays_per_pixel`, whatever comes of it.
  std::optional<long> max_rays_per_pixel;
};

struct Rectangle {
  int x = 0;  ///< pixels, from the left
  int y = 0;  ///< pixels, from the top
  int width = 0;
  int height = 0;
  bool operator==(const Rectangle&) const = default;
};

/// A part of the picture in which the metrics are measured on their own, as of a view of its own.
struct Region {
  std::string name;
  Rectangle rectangle;  ///< inside the frame
  bool point = false;   ///< one pixel, of which the brightness alone is measured
  bool operator==(const Region&) const = default;
};

/// What a scene is seen with: a point of the axes of [scene] and [probe].
struct BenchSettings {
  SceneSettings scene;
  std::optional<ProbeSettings> probe;  ///< none: the scene's own environment
  NamedValues point = {};              ///< the same on the axes: scene.source, scene.view, ...
  std::vector<Region> regions = {};    ///< [[region]], and what figures show enlarged or mark
};

struct RunSettings {
  std::vector<std::string> methods;
  Grid grid;  ///< of parameters; an exclusion may also name the axis `method`
  std::vector<long> seeds = {0};
};

struct Resolution {
  int width = 0;  ///< pixels
  int height = 0;
  bool operator==(const Resolution&) const = default;
};

inline constexpr int most_rasteriser_threads = 32;

struct TimingSettings {
  std::vector<std::string> methods;
  std::vector<Axis> axes;
  // Three more axes; empty: as the scene and the environment have it.
  std::vector<Resolution> resolutions;
  std::vector<long> triangles;   ///< each of the scene's is split until there are about so many
  std::vector<long> threads;     ///< of the software rasteriser
  bool one_by_one = false;       ///< the axes are varied one at a time, else crossed
  std::string baseline;          ///< one of `methods`
  NamedValues baseline_at = {};  ///< values of axes, where ratios are not to the cell's own
  int repetitions = 7;           ///< at least
  double budget_seconds = 60.0;
  std::string published;  ///< results/published/NAME.csv; empty: none
  std::string note;       ///< stands under the table; may be empty
};

/// The error budget of every method of the runs (error_budget.h).
struct BudgetSettings {
  double tolerance = 0.02;        ///< of the converged runs: methods/converged.h
  double budget_seconds = 120.0;  ///< for each of them
};

enum class FigureKind {
  comparison,
  closeups,
  error_map,
  error_budget,
  failure_classes,
  ambient_occlusion,
  lobes,
  grid,
};

struct CloseupRow {
  std::string label;
  Rectangle rectangle;  ///< inside the frame
  NamedValues select;
};

/// A point of the surface that a figure says more of.
struct FigurePoint {
  std::string label;
  int x = 0;  ///< pixels, inside the frame
  int y = 0;
};

/// A column or a row of a figure of kind `grid`.
struct GridEntry {
  std::string label;
  std::string method;                  ///< empty: the entries of the other way say it
  NamedValues select;                  ///< parameters
  std::vector<Axis> bench;             ///< values of [scene] and [probe]
  std::optional<Rectangle> rectangle;  ///< a row that shows a part of the frame, enlarged
};

/// What a column and a row of a grid select together.
struct GridPanel {
  std::string method;
  NamedValues select;  ///< picks one cell of the method
  std::size_t bench = 0;
};

struct FigureSettings {
  std::string name;  ///< the file's name
  FigureKind kind = FigureKind::comparison;
  std::string title;
  std::string stage = "filtered";  ///< or "unfiltered"
  std::vector<std::string> methods;
  std::size_t bench = 0;         ///< of Experiment::benches; grid: that of the first panel
  NamedValues select;            ///< all but closeups and grid: picks one cell of each method
  std::vector<CloseupRow> rows;  ///< closeups
  double scale = 0.0;            ///< of errors: what is shown as the end of the colour scale
  std::string caption;           ///< what to see; stands before what is said of every such figure
  std::vector<FigurePoint> points;    ///< lobes
  std::vector<std::string> switched;  ///< lobes: two lights that also change their places, or none
  std::vector<GridEntry> columns;     ///< grid
  std::vector<GridEntry> grid_rows;
  std::vector<GridPanel> panels;  ///< grid, row by row
};

struct Experiment {
  std::filesystem::path file;
  std::string resolved;  ///< the file as TOML after the overrides, for run.json
  std::string name;
  std::string title;
  SceneSettings scene;  ///< with `probe` the first of `benches`; see at_bench()
  std::optional<ProbeSettings> probe;
  /// Every scene, view, resolution and probe, each of which has all cells; not empty. The first
  /// varies slowest: what is shared, such as a loaded scene, comes one after the other.
  std::vector<BenchSettings> benches;
  NamedValues parameters;  ///< for every method that declares them
  std::optional<ReferenceSettings> reference;
  std::vector<RunSettings> runs;
  std::optional<BudgetSettings> budget;
  std::optional<TimingSettings> timing;
  std::vector<FigureSettings> figures;
};

/// Reads and validates an experiment file. `overrides` are the texts of --set KEY=VALUE, applied
/// before validation. Throws InputError "FILE:LINE: key 'run[1].sampels': unknown; did you mean
/// ..."; what an override brought in is reported as "--set KEY=VALUE" instead of FILE:LINE.
Experiment load_experiment(const std::filesystem::path& path,
                           const std::vector<std::string>& overrides,
                           const std::vector<MethodInfo>& methods);

/// The experiment with that one bench, and the figures of it alone; grids are left out.
Experiment at_bench(const Experiment& experiment, const BenchSettings& bench);

enum class Role { reference, test };

struct PlannedCell {
  Role role = Role::test;
  std::string method;
  ParameterSet parameters;  ///< refers to the declarations in `methods`
  int group = 0;            ///< the same for cells that differ in their seed only; 0, 1, ...
  std::string truth = {};   ///< MethodInfo::truth
};

/// The place of the reference that a test is compared with: that of its truth, or the first.
/// `cells`: the whole plan, or anything that begins with its references and has `planned`.
std::size_t reference_place(const std::vector<PlannedCell>& cells, const PlannedCell& test);

/// The cells to render, the references first, then run by run: methods, axes, seeds (fastest).
/// `methods` outlives the result.
std::vector<PlannedCell> plan(const Experiment& experiment, const std::vector<MethodInfo>& methods);

/// What is timed: a method under what its time depends on.
struct TimedCell {
  PlannedCell cell;  ///< cells of one point of the axes share a group: they have one baseline
  Resolution resolution;
  long triangles = 0;             ///< asked for; 0: as the scene is
  int threads = 0;                ///< 0: as the environment says
  std::vector<std::string> axes;  ///< where axes are varied one by one: those this is a point of
};

/// The names of the axes that are no parameters.
inline constexpr const char* resolution_axis = "resolution";
inline constexpr const char* triangles_axis = "triangles";
inline constexpr const char* threads_axis = "threads";

/// The cells to time: for each point of the axes every method. Crossed, the first axis varies
/// slowest: threads, triangles, resolution, then the parameters. One by one, a point is that of
/// [scene] and [parameters] with one value of one axis in its place; equal points are one. Empty
/// without [timing].
std::vector<TimedCell> plan_timing(const Experiment& experiment,
                                   const std::vector<MethodInfo>& methods);

/// No group of cells, or several, where one was to be selected.
class SelectionError : public InputError {
 public:
  using InputError::InputError;
};

/// The group of `method` with the selected values; values of parameters that the method does not
/// declare do not matter. load_experiment has made sure that each figure selects exactly one group
/// of each of its methods. Throws SelectionError otherwise.
int select_group(const std::vector<PlannedCell>& cells, const std::string& method,
                 const NamedValues& select);

}  // namespace occlab
