#pragma once

#include <functional>
#include <future>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "harness/bench_plan.h"
#include "harness/cell_writer.h"
#include "harness/certification.h"
#include "harness/experiment_figures.h"
#include "harness/measure.h"
#include "harness/shared_work.h"
#include "harness/work_clock.h"
#include "harness/workbench.h"

namespace occlab {

/// What the benches of a run share.
class RunTools {
 public:
  RunTools(std::shared_ptr<Equipment> equipment, std::function<void(std::string)> warning)
      : warn(std::move(warning)), equipment_(std::move(equipment)) {}

  /// Where cells are stored from now on.
  void use(const std::filesystem::path& folder);
  CellStore& store() { return *store_; }
  CellWriter& writer() { return *writer_; }

  /// The bench's workbench; the one that was open before is closed. Says what is to be said of its
  /// scene and its probe, once.
  Workbench& open(const BenchPlan& bench);
  const DeviceInfo& device() const { return equipment_->device(); }
  OcclusionMethod& method(const std::string& name);

  WorkClock clock;
  std::function<void(std::string)> warn;

 private:
  std::shared_ptr<Equipment> equipment_;
  std::optional<CellStore> store_;
  std::optional<CellWriter> writer_;
  std::optional<Workbench> open_;
  const BenchPlan* plan_ = nullptr;  ///< of open_
  std::vector<std::string> said_;
  std::map<std::string, std::unique_ptr<OcclusionMethod>> methods_;  ///< by name, once used
};

/// Renders, certifies and measures the cells of one bench.
class BenchRun {
 public:
  /// `tools` outlives the run.
  BenchRun(BenchPlan plan, RunTools& tools);

  const BenchPlan& plan() const { return plan_; }
  /// How to make the cells and budgets. The result lives no longer than this.
  std::vector<WorkItem> work_items();

  /// Traces more rays for the reference until it is certified or its budget ends. What an earlier
  /// run came to for the same cells (report_reference()) is taken from it. Afterwards
  /// cells().front() is the reference with all its rays. 0 where nothing was missing.
  std::size_t sample_reference(const nlohmann::json& known);
  /// Calls `sink` with the rows of every measurement but times.
  void measure(const RowSink& sink);
  /// What the experiment's figures are drawn of. For after sample_reference(); lives no longer than
  /// this.
  FigureBench for_figures();

  /// For after sample_reference(): every cell with the steps towards the reference.
  std::vector<KeyedCell> all_cells() const;
  /// What run.json keeps of the reference; `rows`: those of any bench that is_of_certification().
  nlohmann::json report_reference(const std::vector<Measurement>& rows) const;

  bool has_reference() const { return chain_.has_value(); }
  /// The hashes of all cells: with the experiment what measurements depend on.
  std::string hashes() const;
  /// Whether the row is a measurement of this bench.
  bool is_of(const Measurement& row) const;

 private:
  void render(const KeyedCell& cell);
  void converge(const KeyedBudget& budget);
  Certification judge_reference();
  Layers read_cell(const KeyedCell& cell);
  /// Warns of what a rendering found out, if it has not before.
  void tell(const ParameterSet& parameters, const Metadata& facts);
  ReadLayers reader();
  StoredBudget read_budget(const KeyedBudget& budget);
  ReadBudget budget_reader();
  std::vector<MeasuredCell> measured_cells() const;
  Measurement identity() const;

  BenchPlan plan_;
  RunTools& tools_;
  std::optional<ReferenceChain> chain_;
  std::string reference_key_;
  std::map<std::string, std::size_t> places_;  ///< of cells by id
  std::string next_id_;                        ///< what is being read ahead
  std::future<ReadCell> next_;
  std::set<std::string> told_;
};

/// Whether certify() needs the row.
bool is_of_certification(const Measurement& row);

/// Of measurements made on these cells: the same while they stand for each other.
std::string measuring_key(const Experiment& experiment, const std::string& hashes);

}  // namespace occlab
