#include "harness/runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "harness/bench_run.h"
#include "harness/environment_report.h"
#include "harness/experiment_tables.h"
#include "harness/files.h"
#include "harness/results_folder.h"
#include "harness/run_facts.h"
#include "harness/table_layout.h"
#include "harness/timing.h"
#include "renderers/scene/error.h"
#include "renderers/scene/interrupt.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

fs::path results_folder(const RunOptions& options) {
  if (options.fresh) remove_results(options.out);
  return options.out;
}

/// Rows of two benches that are called the same could not be told apart.
void refuse_equal_names(const std::vector<BenchPlan>& benches, const DeviceInfo& device,
                        const fs::path& file) {
  std::set<std::vector<std::string>> names;
  for (const BenchPlan& bench : benches) {
    const Measurement row = shared_facts(bench, device);
    if (names.insert({row.scene, row.view, row.resolution, row.probe}).second) continue;
    throw InputError(
        fmt::format("{}: key 'scene': two benches are called scene {}, view {}, {}, "
                    "probe {} in the tables; accepted are different names",
                    file.string(), row.scene, row.view, row.resolution, row.probe));
  }
}

/// The columns of all measurements but times: every parameter of the tests, then the reference's.
std::vector<std::string> parameter_names(const BenchPlan& bench) {
  std::vector<std::string> names;
  for (const Role role : {Role::test, Role::reference}) {
    for (const KeyedCell& cell : bench.cells) {
      if (cell.planned.role != role) continue;
      merge_names(names, named_parameters(cell.planned.parameters));
    }
  }
  return names;
}

/// What was measured, as far as it is in memory.
struct Measured {
  std::vector<Measurement> rows;           ///< all, unless there are more than most_rows_of_tables
  std::vector<Measurement> certification;  ///< those that is_of_certification()
  std::size_t count = 0;
  json timing_context;
};

/// One run over one results folder.
class Run {
 public:
  Run(const Experiment& experiment, const RunOptions& options)
      : experiment_(experiment),
        equipment_(std::make_shared<Equipment>(options.device)),
        tools_(equipment_, [this](std::string warning) { warn(std::move(warning)); }),
        results_(options.out),
        shard_(options.shard) {
    const DeviceInfo& device = tools_.device();
    std::vector<BenchPlan> plans =
        plan_benches(experiment, device.renderer, device.version,
                     [this](const std::string& source) -> const LoadedScene& {
                       return equipment_->scene(source);
                     });
    refuse_equal_names(plans, device, experiment.file);
    tools_.open(plans.front());
    tools_.use(results_folder(options));  // a run that cannot start leaves the folder as it was
    for (BenchPlan& plan : plans) {
      benches_.push_back(std::make_unique<BenchRun>(std::move(plan), tools_));
    }
    std::vector<WorkItem> items;
    for (const auto& bench : benches_)
      std::ranges::move(bench->work_items(), std::back_inserter(items));
    work_.emplace(tools_.store(), std::move(items),
                  WorkOptions{.flush = [this] { tools_.writer().flush(); },
                              .shard = options.shard,
                              .cell_seconds = options.cell_seconds},
                  [this](std::string warning) { warn(std::move(warning)); });
  }

  void finish() {
    try {
      const std::size_t rendered = work_->make_missing();
      tools_.clock.in(storing_work, [&] { work_->settle(); });
      if (shard_) {
        work_->log().end("rendered");
        fmt::print(stderr, "shard {} is done; the same command without --shard measures\n",
                   to_string(*shard_));
        return;
      }
      const WorkLocks::Lock others_wait = work_->collect();
      if (others_wait.held()) results_.remove_left_overs();
      measure_what_is_missing(rendered);
      work_->log().end("finished");
    } catch (const Interrupted&) {
      tools_.writer().flush();
      const std::string message = fmt::format(
          "interrupted; {} of {} cells are finished and kept, the same command goes on "
          "from there",
          work_->finished(), work_->planned());
      work_->log().end("interrupted", message);
      throw Interrupted(message);
    } catch (const std::exception& error) {
      work_->log().end("failed", error.what());
      throw;
    }
  }

 private:
  void measure_what_is_missing(std::size_t rendered) {
    const json previous =
        results_.read_report([this](std::string warning) { warn(std::move(warning)); });
    for (std::size_t i = 0; i < benches_.size(); ++i) {
      rendered += benches_[i]->sample_reference(known_reference(previous, i));
    }
    const BenchPlan& first = benches_.front()->plan();
    const std::string timing_key = timing_key_of(experiment_, first.facts);
    const bool timed = previous.value("timing_key", "") == timing_key;
    const bool measured = previous.value("measuring_key", "") == key();
    if (rendered == 0 && timed && measured && results_.has_outputs(!experiment_.figures.empty())) {
      fmt::print(stderr, "{}: everything is done; --fresh does it again\n",
                 tools_.store().folder().string());
      print_known_tables(previous);
      return;
    }
    work_->begin_measuring();
    const Measured found = collect(measured, timed, previous);
    const TimingTableSettings settings = timing_table_settings(experiment_, found.timing_context);
    const std::vector<Table> tables = tools_.clock.in(figures_work, [&] {
      std::vector<Table> made = make_tables(found.rows, settings);
      write_tables(made, tools_.store().folder() / "tables");
      if (!experiment_.figures.empty()) {
        std::vector<FigureBench> benches;
        for (const auto& bench : benches_) benches.push_back(bench->for_figures());
        write_figures(experiment_, benches, tools_.store().folder() / "figures");
      }
      return made;
    });
    json report = environment_report(experiment_, tools_.open(first));
    report["measuring_key"] = key();
    report["timing_key"] = timing_key;
    report["timing"] = found.timing_context;
    report["timing_table"] = to_json(settings);
    report["measurement_count"] = found.count;
    report["measurements_sha256"] = sha256_file(results_.measurements());
    report["warnings"] = warnings_;
    add_benches(report, found.certification);
    report["cells"] = report_cells();
    report["wall_time"] = tools_.clock.report();
    write_text_atomically(results_.report(), report.dump(2) + "\n");
    fmt::print(stderr, "{}\n", overhead_sentence(report["wall_time"]));
    print_tables(tables, "md");
  }

  /// What an earlier run came to for the reference of a bench.
  json known_reference(const json& previous, std::size_t index) const {
    if (benches_.size() == 1) return previous.value("reference", json::object());
    const json benches = previous.value("benches", json::array());
    if (index >= benches.size()) return json::object();
    return benches[index].value("reference", json::object());
  }

  void print_known_tables(const json& previous) const {
    if (previous.value("measurement_count", std::size_t(0)) > most_rows_of_tables) {
      return say_there_are_no_tables(previous["measurement_count"].get<std::size_t>());
    }
    print_tables(make_tables(read_measurements(results_.measurements()),
                             timing_table_settings(experiment_, previous.value("timing", json()))),
                 "md");
  }

  static void say_there_are_no_tables(std::size_t count) {
    fmt::print(stderr,
               "{} measurements: tables are made of up to {}; 'occlab query' reads any number\n",
               count, most_rows_of_tables);
  }

  /// Measures and times what is to be done again, writes measurements.csv and takes the rest from
  /// the one there is.
  Measured collect(bool measured, bool timed, const json& previous) {
    if (!measured && !experiment_.timing) return measure_to_file();
    Measured found;
    if (measured) {
      found.rows = results_.rows(false);
    } else {
      measure([&](const std::vector<Measurement>& rows) {
        found.rows.insert(found.rows.end(), rows.begin(), rows.end());
      });
    }
    std::ranges::copy_if(found.rows, std::back_inserter(found.certification), is_of_certification);
    if (timed) found.timing_context = previous.value("timing", json());
    if (experiment_.timing) {
      std::vector<Measurement> times;
      if (timed) {
        times = results_.rows(true);
      } else {
        const BenchPlan& plan = benches_.front()->plan();
        TimingResult timing = tools_.clock.in(timing_work, [&] {
          return time_methods(experiment_, tools_.open(plan), shared_facts(plan, tools_.device()));
        });
        times = std::move(timing.measurements);
        found.timing_context = std::move(timing.context);
      }
      found.rows.insert(found.rows.end(), times.begin(), times.end());
    }
    found.count = found.rows.size();
    write_measurements(results_.measurements(), found.rows);
    if (found.count > most_rows_of_tables) {
      found.rows.clear();
      say_there_are_no_tables(found.count);
    }
    return found;
  }

  void measure(const RowSink& sink) {
    for (const auto& bench : benches_) {
      tools_.clock.in(measuring_work, [&] {
        bench->measure([&](std::vector<Measurement> rows) {
          tools_.clock.in(storing_work, [&] { sink(std::move(rows)); });
        });
      });
    }
  }

  /// Row by row: a sweep's are more than should be in memory.
  Measured measure_to_file() {
    Measured found;
    MeasurementsFile file(results_.measurements(), parameter_names(benches_.front()->plan()));
    measure([&](const std::vector<Measurement>& rows) {
      file.add(rows);
      std::ranges::copy_if(rows, std::back_inserter(found.certification), is_of_certification);
    });
    file.finish();
    found.count = file.rows();
    if (found.count <= most_rows_of_tables) {
      found.rows = read_measurements(results_.measurements());
    } else {
      say_there_are_no_tables(found.count);
    }
    return found;
  }

  /// What a report says of one bench it says of each of several.
  void add_benches(json& report, const std::vector<Measurement>& certification) const {
    if (benches_.size() == 1) {
      if (experiment_.reference) {
        report["reference"] = benches_.front()->report_reference(certification);
      }
      return;
    }
    report["schema"] = schema_of_several_benches;
    for (const char* name : {"scene", "view", "resolution", "probe"}) report.erase(name);
    report["benches"] = json::array();
    for (const auto& bench : benches_) {
      const BenchFacts& facts = bench->plan().facts;
      json entry = {
          {"scene", {{"name", bench->plan().scene}, {"sha256", facts.scene_hash}}},
          {"view", facts.view},
          {"resolution", {facts.resolution.width, facts.resolution.height}},
          {"probe", {{"description", describe(facts.probe)}, {"sha256", facts.probe_hash}}}};
      if (experiment_.reference) entry["reference"] = bench->report_reference(certification);
      report["benches"].push_back(std::move(entry));
    }
  }

  json report_cells() const {
    json cells = json::array();
    for (std::size_t i = 0; i < benches_.size(); ++i) {
      const auto add = [&](json cell) {
        if (benches_.size() > 1) cell["bench"] = i;
        cells.push_back(std::move(cell));
      };
      for (const KeyedCell& cell : benches_[i]->all_cells()) {
        add({{"id", cell.key.id()},
             {"hash", cell.key.hash()},
             {"method", cell.planned.method},
             {"parameters", cell.planned.parameters.to_string()}});
      }
      for (const KeyedBudget& budget : benches_[i]->plan().budgets) {
        add({{"id", budget.key.id()}, {"hash", budget.key.hash()}, {"budget", budget.key.facts()}});
      }
    }
    return cells;
  }

  void warn(std::string warning) {
    fmt::print(stderr, "occlab: {}\n", warning);
    warnings_.push_back(std::move(warning));
  }

  std::string key() const {
    std::string hashes;
    for (const auto& bench : benches_) hashes += bench->hashes();
    return measuring_key(experiment_, hashes);
  }

  const Experiment& experiment_;
  std::vector<std::string> warnings_;
  std::shared_ptr<Equipment> equipment_;
  RunTools tools_;
  ResultsFolder results_;
  std::vector<std::unique_ptr<BenchRun>> benches_;
  std::optional<Shard> shard_;
  std::optional<SharedWork> work_;
};

}  // namespace

void run_experiment(const Experiment& experiment, const RunOptions& options) {
  require_own_threads(experiment);
  Run(experiment, options).finish();
}

}  // namespace occlab
