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

/// "1280x720", with sides that are accepted; nothing for any other text.
std::optional<Resolution> parse_resolution(const std::string& text);
inline constexpr int shortest_side = 16;
inline constexpr int longest_side = 16384;

RunSettings read_run(TomlTable& table, const std::vector<MethodInfo>& methods);

TimingSettings read_timing(TomlTable table, const std::vector<MethodInfo>& methods);

/// What reading a figure needs of the rest of the experiment.
struct FigureContext {
  const SceneSettings& scene;
  const std::vector<MethodInfo>& methods;
  const std::vector<PlannedCell>& cells;
  bool budget;
};
FigureSettings read_figure(TomlTable& table, const FigureContext& context);

}  // namespace occlab
