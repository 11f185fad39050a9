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
};

/// The keys that are left in a table: parameters of `methods`, with valid values.
std::vector<Axis> read_parameters(TomlTable& table, const std::vector<const MethodInfo*>& methods,
                                  const ParameterRules& rules);

/// The first value of each.
NamedValues single_values(const std::vector<Axis>& axes);

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
