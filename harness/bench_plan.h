#pragma once

#include <functional>
#include <string>
#include <vector>

#include "harness/cell_index.h"
#include "harness/cells.h"
#include "harness/config.h"
#include "harness/error_budget.h"
#include "harness/reference_chain.h"

namespace occlab {

struct KeyedBudget {
  BudgetCell cell;
  CellKey key;
};

/// Everything that an experiment makes with one scene, view, resolution and probe.
struct BenchPlan {
  Experiment experiment;  ///< at_bench()
  std::string scene;      ///< Scene::name
  BenchFacts facts;
  std::vector<KeyedCell> cells;  ///< the reference first, without the further rays it may need
  std::vector<KeyedBudget> budgets;
};

/// Fills in `cells` and `budgets`.
BenchPlan plan_bench(Experiment experiment, std::string scene, BenchFacts facts);

/// Where scenes come from; a scene is asked for several times in a row.
using SceneSource = std::function<const LoadedScene&(const std::string& source)>;

/// The same for each bench of an experiment, without a graphics context: `device` and `driver` are
/// DeviceInfo's. Throws InputError where a scene, a view or a probe is not to be had.
std::vector<BenchPlan> plan_benches(const Experiment& experiment, const std::string& device,
                                    const std::string& driver, const SceneSource& scenes);

/// What the workbench of an experiment's (first) bench is opened with.
ViewSettings view_settings(const Experiment& experiment);

/// "s3ho samples=16 steps=2 seed=3": a cell on a terminal.
std::string label(const PlannedCell& cell);
std::string label(const BudgetCell& cell);

}  // namespace occlab
