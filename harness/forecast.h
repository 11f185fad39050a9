#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "harness/bench_plan.h"
#include "harness/cell_index.h"
#include "harness/tables.h"

namespace occlab {

// What a run would do, without a graphics context where that can be had: the keys of cells have the
// device and its driver in them, and those are taken from the cells that are there.

/// The device for which cells are planned.
struct PlannedDevice {
  std::string renderer;
  std::string driver;
  std::string note;  ///< where this is from
};

/// `device` "auto": that of most of `stored`, or, without any, an unknown one; otherwise a context
/// is opened on it. Throws as Context does.
PlannedDevice planned_device(const std::string& device,
                             const std::map<std::string, CellDescription>& stored);

/// plan_benches() for that device. Loads one scene at a time.
std::vector<BenchPlan> plan_without_context(const Experiment& experiment,
                                            const PlannedDevice& device);

/// One cell, or one error budget, of a planned run.
struct ForecastCell {
  const BenchPlan* bench = nullptr;
  const KeyedCell* cell = nullptr;      ///< nullptr: a budget
  const KeyedBudget* budget = nullptr;  ///< nullptr: a cell
  const CellKey& key() const { return cell ? cell->key : budget->key; }
  std::string what;  ///< label()
  bool finished = false;
  double seconds =
      0.0;  ///< measured where it is finished and said how long it took, else estimated
  bool measured = false;
};

/// estimated_seconds() times a factor for each method: how long its finished cells took, over what
/// the model says of them; that of all methods for one that has none; else 1.
struct Forecast {
  std::vector<ForecastCell> cells;
  std::vector<std::string> notes;  ///< where the seconds and the device are from

  std::size_t finished() const;
  /// Of the cells that are not finished.
  double seconds_to_do() const;
};

/// `benches` outlives the result.
Forecast forecast(const std::vector<BenchPlan>& benches, const PlannedDevice& device,
                  const std::map<std::string, CellDescription>& stored);

/// One row a cell; what is the same of all is left out.
Table forecast_table(const Forecast& forecast);
nlohmann::json forecast_json(const Forecast& forecast);

}  // namespace occlab
