#include "harness/runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "harness/cells.h"
#include "harness/certification.h"
#include "harness/environment_report.h"
#include "harness/error_budget.h"
#include "harness/experiment_figures.h"
#include "harness/experiment_tables.h"
#include "harness/measure.h"
#include "harness/progress.h"
#include "harness/reference_chain.h"
#include "harness/results_folder.h"
#include "harness/run_facts.h"
#include "harness/shared_work.h"
#include "harness/store.h"
#include "harness/timing.h"
#include "harness/version.h"
#include "harness/work_clock.h"
#include "renderers/scene/error.h"
#include "renderers/scene/interrupt.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

using PlannedKey = KeyedCell;

struct PlannedBudget {
  BudgetCell cell;
  CellKey key;
};

std::string label(const PlannedCell& cell) {
  std::string text = cell.method;
  for (const char* name : {"samples", "steps", "seed", "rays_per_pixel"}) {
    if (cell.parameters.has(name)) {
      text += fmt::format(" {}={}", name, to_string(cell.parameters.value(name)));
    }
  }
  return text;
}

std::string label(const BudgetCell& cell) {
  std::string text = "error budget of";
  for (const BudgetVariant& variant : cell.variants) text += " " + variant.name;
  return text;
}

fs::path results_folder(const RunOptions& options) {
  if (options.fresh) remove_results(options.out);
  return options.out;
}

/// One run over one results folder.
class Run {
 public:
  Run(const Experiment& experiment, const RunOptions& options)
      : experiment_(experiment),
        bench_({.scene = experiment.scene.source,
                .view = experiment.scene.view,
                .width = experiment.scene.width,
                .height = experiment.scene.height,
                .probe = experiment.probe},
               options.device),
        store_(results_folder(options)),
        results_(options.out),
        shard_(options.shard) {
    for (PlannedCell& cell : plan(experiment, methods())) {
      CellKey key = cell_key(bench_, cell);
      cells_.push_back({std::move(cell), std::move(key)});
    }
    if (experiment.reference) {
      chain_.emplace(bench_, store_, cells_.front(),
                     [this](const KeyedCell& part) { return read_cell(part); });
    }
    if (experiment.budget) {
      for (BudgetCell& cell : plan_budget(plan(experiment, methods()))) {
        CellKey key = budget_key(bench_, cell, *experiment.budget);
        budgets_.push_back({std::move(cell), std::move(key)});
      }
    }
    warnings_ = bench_.scene().warnings;
    if (const auto clamped = bench_.frame().lighting.environment().clamped_negative_texels) {
      warn(fmt::format("{}: {} slightly negative texels were set to 0", bench_.probe().source,
                       clamped));
    }
    for (const std::string& warning : warnings_) fmt::print(stderr, "occlab: {}\n", warning);
    work_.emplace(store_, work_items(),
                  WorkOptions{.shard = options.shard, .cell_seconds = options.cell_seconds},
                  [this](std::string warning) { warn_now(std::move(warning)); });
  }

  void finish() {
    try {
      const std::size_t rendered = work_->make_missing();
      if (shard_) {
        work_->log().end("rendered");
        fmt::print(stderr, "shard {} is done; the same command without --shard measures\n",
                   to_string(*shard_));
        return;
      }
      const Claims::Claim others_wait = work_->collect();
      measure_what_is_missing(rendered);
      work_->log().end("finished");
    } catch (const Interrupted&) {
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
  std::vector<WorkItem> work_items() {
    const auto& [source, view, width, height] = experiment_.scene;
    std::vector<WorkItem> items;
    for (const PlannedKey& cell : cells_) {
      items.push_back({.key = cell.key,
                       .what = label(cell.planned),
                       .cost = estimated_seconds(cell.planned, width, height),
                       .make = [this, cell] { render(cell); }});
    }
    for (const PlannedBudget& budget : budgets_) {
      items.push_back({.key = budget.key,
                       .what = label(budget.cell),
                       .cost = estimated_seconds(budget.cell, *experiment_.budget, width, height),
                       .make = [this, &budget] { converge(budget); }});
    }
    return items;
  }

  void measure_what_is_missing(std::size_t rendered) {
    const json previous =
        results_.read_report([this](std::string warning) { warn_now(std::move(warning)); });
    const std::string reference_key = make_measuring_key();
    rendered += sample_reference(previous, reference_key);
    const std::string timing_key = timing_key_of(experiment_, bench_);
    const bool timed = previous.value("timing_key", "") == timing_key;
    const bool measured = previous.value("measuring_key", "") == make_measuring_key();
    if (rendered == 0 && timed && measured && results_.has_outputs(!experiment_.figures.empty())) {
      fmt::print(stderr, "{}: everything is done; --fresh does it again\n",
                 store_.folder().string());
      fmt::print("{}",
                 format_tables(make_tables(read_measurements(results_.measurements()),
                                           timing_table_settings(experiment_,
                                                                 previous.value("timing", json()))),
                               "md"));
      return;
    }
    std::vector<Measurement> rows =
        measured ? results_.rows(false) : clock_.in(measuring_work, [&] { return measure(); });
    json timing_context = timed ? previous.value("timing", json()) : json();
    std::vector<Measurement> times;
    if (experiment_.timing) {
      if (timed) {
        times = results_.rows(true);
      } else {
        TimingResult timing =
            clock_.in(timing_work, [&] { return time_methods(experiment_, bench_, identity()); });
        times = std::move(timing.measurements);
        timing_context = std::move(timing.context);
      }
    }
    rows.insert(rows.end(), times.begin(), times.end());
    write_measurements(results_.measurements(), rows);
    const TimingTableSettings table_settings = timing_table_settings(experiment_, timing_context);
    const std::vector<Table> tables = clock_.in(figures_work, [&] {
      std::vector<Table> made = make_tables(rows, table_settings);
      write_tables(made, store_.folder() / "tables");
      write_figures(experiment_, measured_cells(), reader(), budget_reader(),
                    store_.folder() / "figures");
      return made;
    });
    json report = environment_report(experiment_, bench_);
    report["measuring_key"] = make_measuring_key();
    if (chain_) {
      report["reference"] = to_json(*certify(rows));
      report["reference"].update(
          {{"cell", chain_->mean().key.id()}, {"parts", chain_->parts()}, {"key", reference_key}});
    }
    report["timing_key"] = timing_key;
    report["timing"] = timing_context;
    report["timing_table"] = to_json(table_settings);
    report["measurements_sha256"] = sha256_file(results_.measurements());
    report["warnings"] = warnings_;
    report["cells"] = json::array();
    std::vector<PlannedKey> all = cells_;
    if (chain_) std::ranges::copy(chain_->steps(), std::back_inserter(all));
    for (const PlannedKey& cell : all) {
      report["cells"].push_back({{"id", cell.key.id()},
                                 {"hash", cell.key.hash()},
                                 {"method", cell.planned.method},
                                 {"parameters", cell.planned.parameters.to_string()}});
    }
    for (const PlannedBudget& budget : budgets_) {
      report["cells"].push_back(
          {{"id", budget.key.id()}, {"hash", budget.key.hash()}, {"budget", budget.key.facts()}});
    }
    report["wall_time"] = clock_.report();
    write_text_atomically(results_.report(), report.dump(2) + "\n");
    fmt::print(stderr, "{}\n", overhead_sentence(report["wall_time"]));
    fmt::print("{}", format_tables(tables, "md"));
  }

  void warn(std::string warning) { warnings_.push_back(std::move(warning)); }

  /// For what is found on the way; the constructor prints what is found at the start.
  void warn_now(std::string warning) {
    fmt::print(stderr, "occlab: {}\n", warning);
    warn(std::move(warning));
  }

  void render(const PlannedKey& cell) {
    auto& method = instances_[cell.planned.method];
    if (!method) method = find_method(cell.planned.method).make();
    Metadata facts;
    const bool traced = cell.planned.role == Role::reference;
    const Layers layers = clock_.in(traced ? tracing_work : rendering_work, [&] {
      return render_cell(bench_, cell.planned, *method, facts);
    });
    clock_.in(storing_work, [&] {
      store_.write(cell.key, layers, cell_metadata(bench_, cell.planned, facts), json(facts));
    });
  }

  /// Traces more rays for the reference until it is certified or its budget ends. What an earlier
  /// run came to for the same cells is taken from it. 0 where nothing was missing.
  std::size_t sample_reference(const json& previous, const std::string& key) {
    if (!chain_) return 0;
    const json known = previous.value("reference", json::object());
    if (known.value("key", "") == key) {
      const auto parts = known.at("parts").get<std::vector<long>>();
      for (std::size_t i = 1; i < parts.size(); ++i) chain_->extend(parts[i]);
    } else if (experiment_.reference->max_rays_per_pixel) {
      const auto judged = [&] {
        return clock_.in(measuring_work, [&] { return judge_reference(); });
      };
      while (const long more = more_rays(judged(), chain_->parts().front())) {
        throw_if_interrupted();
        fmt::print(stderr, "reference: {} rays a pixel are too few, {} more\n",
                   chain_->rays_per_pixel(), more);
        chain_->extend(more);
      }
    }
    const bool finished = chain_->finished();
    if (!finished) chain_->read();
    cells_.front() = chain_->mean();
    return finished ? 0 : 1;
  }

  /// Of the first seeds, and a little stricter than what is said of it in the end.
  Certification judge_reference() {
    const Layers layers = chain_->read();
    const PlannedKey& mean = chain_->mean();
    ReferenceSettings settings = *experiment_.reference;
    settings.tolerance *= 0.97;
    std::vector<Measurement> rows =
        reference_rows({mean.planned, mean.key.id()}, layers, settings, identity());
    const std::vector<Measurement> errors =
        quick_errors(measured_cells(), layers, identity(), reader());
    rows.insert(rows.end(), errors.begin(), errors.end());
    return *certify(rows);
  }

  void converge(const PlannedBudget& budget) {
    Metadata facts;
    const Layers layers = clock_.in(tracing_work, [&] {
      return render_budget(bench_, budget.cell, *experiment_.budget, facts);
    });
    Metadata metadata = workbench_metadata(bench_);
    for (const auto& [name, value] : facts) metadata["occlab:" + name] = value;
    clock_.in(storing_work, [&] { store_.write(budget.key, layers, metadata, json(facts)); });
  }

  StoredBudget read_budget(const PlannedBudget& budget) {
    ReadCell read = clock_.in(storing_work, [&] { return store_.read(budget.key); });
    if (!read.cell) {
      warn_now(read.warning + "; made again");
      converge(budget);
      read = store_.read(budget.key);
      if (!read.cell) throw DeviceError(read.warning + ", twice in a row");
    }
    return {budget.cell, budget.key.id(), std::move(read.cell->layers),
            read.cell->extra.get<Metadata>()};
  }

  /// The budget of a planned cell; the last one read is kept.
  ReadBudget budget_reader() {
    return [this, kept = std::optional<StoredBudget>()](
               const PlannedCell& cell) mutable -> const StoredBudget& {
      const auto found = std::ranges::find_if(budgets_, [&](const PlannedBudget& budget) {
        return find_variant(budget.cell, cell) != nullptr;
      });
      if (!kept || kept->id != found->key.id()) kept.emplace(read_budget(*found));
      return *kept;
    };
  }

  /// Reads a cell; one that turns out damaged is rendered again, and said so.
  ReadLayers reader() {
    return [this](const MeasuredCell& cell) {
      if (chain_ && cell.id == chain_->mean().key.id()) return chain_->read();
      const auto found = std::ranges::find_if(
          cells_, [&](const PlannedKey& candidate) { return candidate.key.id() == cell.id; });
      return read_cell(*found);
    };
  }

  Layers read_cell(const PlannedKey& cell) {
    ReadCell read = clock_.in(storing_work, [&] { return store_.read(cell.key); });
    if (!read.cell) {
      if (!read.warning.empty()) warn_now(read.warning + "; rendered again");
      render(cell);
      read = store_.read(cell.key);
      if (!read.cell) throw DeviceError(read.warning + ", twice in a row");
    }
    return std::move(read.cell->layers);
  }

  std::vector<MeasuredCell> measured_cells() const {
    std::vector<MeasuredCell> measured;
    for (const PlannedKey& cell : cells_) measured.push_back({cell.planned, cell.key.id()});
    return measured;
  }

  std::vector<Measurement> measure() {
    const std::vector<MeasuredCell> cells = measured_cells();
    Progress progress("measuring", cells.size());
    std::vector<Measurement> rows =
        measure_cells(cells, regions(experiment_), identity(), reader(), [&](std::size_t index) {
          throw_if_interrupted();
          progress.update(index, label(cells[index].planned));
        });
    if (chain_) {
      const std::vector<Measurement> of_reference =
          reference_rows(cells.front(), chain_->read(), *experiment_.reference, identity());
      rows.insert(rows.end(), of_reference.begin(), of_reference.end());
    }
    for (const PlannedBudget& budget : budgets_) {
      throw_if_interrupted();
      const StoredBudget stored = read_budget(budget);
      for (const auto& [name, value] : stored.facts) {
        if (name.ends_with("_reached") && value == "no") {
          warn_now(fmt::format("error budget: {} did not reach the tolerance of {} in its {:g} s",
                               name.substr(0, name.size() - std::string("_reached").size()),
                               experiment_.budget->tolerance, experiment_.budget->budget_seconds));
        }
      }
      const std::vector<Measurement> parts = measure_budget(stored, cells, identity(), reader());
      rows.insert(rows.end(), parts.begin(), parts.end());
    }
    return rows;
  }

  Measurement identity() const { return shared_facts(experiment_, bench_); }

  std::string make_measuring_key() const {
    std::string text = experiment_.resolved + std::string(harness_hash);
    for (const PlannedKey& cell : cells_) text += cell.key.hash();
    for (const PlannedBudget& budget : budgets_) text += budget.key.hash();
    return sha256_text(text);
  }

  WorkClock clock_;  // first: opening the workbench counts
  const Experiment& experiment_;
  Workbench bench_;
  CellStore store_;  // after bench_: a run that cannot start leaves the folder as it was
  ResultsFolder results_;
  std::vector<PlannedKey> cells_;  ///< the reference first, that of all its rays at last
  std::optional<ReferenceChain> chain_;
  std::vector<PlannedBudget> budgets_;
  std::map<std::string, std::unique_ptr<OcclusionMethod>> instances_;  ///< by name, once used
  std::vector<std::string> warnings_;
  std::optional<Shard> shard_;
  std::optional<SharedWork> work_;
};

}  // namespace

void run_experiment(const Experiment& experiment, const RunOptions& options) {
  require_own_threads(experiment);
  Run(experiment, options).finish();
}

}  // namespace occlab
