#pragma once

#include <string>
#include <vector>

#include "harness/config.h"
#include "harness/toml_reader.h"

namespace occlab {

// What the readers of an experiment file's tables share. All throw InputError at the key's place.

bool declares(const MethodInfo& method, const std::string& parameter);

/// The methods named by `key`, each of which exists.
std::vector<const MethodInfo*> known_methods(const TomlTable& table, const std::string& key,
                                             const std::vector<std::string>& names,
                                             const std::vector<MethodInfo>& methods);

/// How a table's parameters are asked for.
struct ParameterRules {
  bool lists = false;     ///< a list of values is an axis
  bool by_all = false;    ///< every method has to declare them, not just one
  bool own_seed = false;  ///< `seed` may be given
  std::vector<std::vector<std::string>> zips = {};  ///< whose axes may have a value twice
};

/// The keys that are left in a table: parameters of `methods`, with valid values.
std::vector<Axis> read_parameters(TomlTable& table, const std::vector<const MethodInfo*>& methods,
                                  const ParameterRules& rules);

/// The first value of each.
NamedValues single_values(const std::vector<Axis>& axes);

/// Refuses, at the key `zip`, a zip of what is no axis and of axes of unequal lengths.
void check_zips(const TomlTable& table, const Grid& grid);

/// Refuses exclusions that name what is no axis or a value that it does not take, exclude nothing,
/// or everything. `tables` are the places of `grid.exclusions`; a run also has the axis `method`.
void check_exclusions(const std::vector<TomlTable>& tables, const Grid& grid,
                      const std::vector<std::string>& methods);

/// Refuses more than most_cells at the table's key.
void check_count(const TomlTable& table, const std::string& key, long cells,
                 const std::string& what);

/// [scene], [probe] and [sweep]: every bench that their axes make.
std::vector<BenchSettings> read_benches(TomlTable& root);

/// Values of the axes of [scene] and [probe], as in an exclusion: what a table has under the keys
/// `scene` and `probe`, if it has them.
std::vector<Axis> read_bench_values(TomlTable& table);

/// The one bench with all these values; fails at the table's `key` otherwise.
std::size_t select_bench(const TomlTable& table, const std::string& key,
                         const std::vector<BenchSettings>& benches,
                         const std::vector<Axis>& values);

/// "1280x720", with sides that are accepted; nothing for any other text.
std::optional<Resolution> parse_resolution(const std::string& text);
inline constexpr int shortest_side = 16;
inline constexpr int longest_side = 16384;

RunSettings read_run(TomlTable& table, const std::vector<MethodInfo>& methods);

TimingSettings read_timing(TomlTable table, const std::vector<MethodInfo>& methods);

/// What reading a figure needs of the rest of the experiment.
struct FigureContext {
  const std::vector<BenchSettings>& benches;
  const std::vector<MethodInfo>& methods;
  const std::vector<PlannedCell>& cells;
  bool budget;
};
FigureSettings read_figure(TomlTable& table, const FigureContext& context);

// What the readers of figures share.

/// The key `rectangle`, [x, y, width, height] inside the frame: integers are pixels, reals
/// fractions of the frame.
Rectangle read_rectangle(TomlTable& table, const SceneSettings& scene);

/// `label` and `pixel`, [x, y] inside the frame: integers are a pixel, reals fractions of the
/// frame.
FigurePoint read_point(TomlTable& table, const SceneSettings& scene);

/// `columns` and `rows` of a grid, and what they select: methods, panels and the bench.
void read_grid(TomlTable& table, const FigureContext& context, FigureSettings& figure);

/// A [[region]].
void read_region(TomlTable& table, std::vector<BenchSettings>& benches);

/// What a figure shows enlarged or marks is also measured there. Refuses, at the table's place, two
/// different regions of one bench that are called the same.
void add_regions(const TomlTable& table, const FigureSettings& figure,
                 std::vector<BenchSettings>& benches);

}  // namespace occlab
