#include "harness/bench_run.h"

#include <fmt/format.h>

#include <algorithm>

#include "harness/files.h"
#include "harness/progress.h"
#include "harness/run_facts.h"
#include "harness/version.h"
#include "renderers/methods/fact_warnings.h"
#include "renderers/scene/error.h"
#include "renderers/scene/interrupt.h"
#include "renderers/scene/parallel.h"

namespace occlab {

using nlohmann::json;

void RunTools::use(const std::filesystem::path& folder) {
  store_.emplace(folder);
  writer_.emplace(*store_);
}

Workbench& RunTools::open(const BenchPlan& bench) {
  if (plan_ == &bench) return *open_;
  plan_ = nullptr;
  open_.reset();  // what it made goes to the equipment before the next one asks for it
  open_.emplace(view_settings(bench.experiment), equipment_);
  plan_ = &bench;
  for (const std::string& warning : open_->warnings()) {
    if (std::ranges::find(said_, warning) != said_.end()) continue;
    said_.push_back(warning);
    warn(warning);
  }
  return *open_;
}

OcclusionMethod& RunTools::method(const std::string& name) {
  std::unique_ptr<OcclusionMethod>& method = methods_[name];
  if (!method) method = find_method(name).make();
  return *method;
}

BenchRun::BenchRun(BenchPlan plan, RunTools& tools) : plan_(std::move(plan)), tools_(tools) {
  if (plan_.experiment.reference) {
    chain_.emplace(
        plan_.facts, tools_.store(), plan_.cells.front(),
        [this](const KeyedCell& part) { return read_cell(part); },
        [this](const PlannedCell& cell, const Metadata& facts) {
          return cell_metadata(tools_.open(plan_), cell, facts);
        });
  }
  reference_key_ = measuring_key(plan_.experiment, hashes());
  for (std::size_t i = 0; i < plan_.cells.size(); ++i) places_[plan_.cells[i].key.id()] = i;
}

std::vector<WorkItem> BenchRun::work_items() {
  const auto& [width, height] = plan_.facts.resolution;
  std::vector<WorkItem> items;
  for (std::size_t i = 0; i < plan_.cells.size(); ++i) {
    const KeyedCell& cell = plan_.cells[i];
    items.push_back({.key = cell.key,
                     .what = label(cell.planned),
                     .cost = estimated_seconds(cell.planned, width, height),
                     .make = [this, i] { render(plan_.cells[i]); }});
  }
  for (const KeyedBudget& budget : plan_.budgets) {
    items.push_back(
        {.key = budget.key,
         .what = label(budget.cell),
         .cost = estimated_seconds(budget.cell, *plan_.experiment.budget, width, height),
         .make = [this, &budget] { converge(budget); }});
  }
  return items;
}

void BenchRun::render(const KeyedCell& cell) {
  Workbench& bench = tools_.open(plan_);
  OcclusionMethod& method = tools_.method(cell.planned.method);
  Metadata facts;
  const bool traced = cell.planned.role == Role::reference;
  Layers layers = tools_.clock.in(traced ? tracing_work : rendering_work,
                                  [&] { return render_cell(bench, cell.planned, method, facts); });
  tools_.clock.in(storing_work, [&] {
    tools_.writer().write(cell.key, std::move(layers), cell_metadata(bench, cell.planned, facts),
                          json(facts));
  });
}

void BenchRun::converge(const KeyedBudget& budget) {
  Workbench& bench = tools_.open(plan_);
  Metadata facts;
  Layers layers = tools_.clock.in(tracing_work, [&] {
    return render_budget(bench, budget.cell, *plan_.experiment.budget, facts);
  });
  Metadata metadata = workbench_metadata(bench);
  for (const auto& [name, value] : facts) metadata["occlab:" + name] = value;
  tools_.clock.in(storing_work, [&] {
    tools_.writer().write(budget.key, std::move(layers), metadata, json(facts));
  });
}

std::size_t BenchRun::sample_reference(const json& known) {
  if (!chain_) return 0;
  const ReferenceSettings& settings = *plan_.experiment.reference;
  if (known.value("key", "") == reference_key_) {
    const auto parts = known.at("parts").get<std::vector<long>>();
    for (std::size_t i = 1; i < parts.size(); ++i) chain_->extend(parts[i]);
  } else if (settings.max_rays_per_pixel) {
    const auto judged = [&] {
      return tools_.clock.in(measuring_work, [&] { return judge_reference(); });
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
  plan_.cells.front() = chain_->mean();
  places_[plan_.cells.front().key.id()] = 0;
  return finished ? 0 : 1;
}

/// Of the first seeds, and a little stricter than what is said of it in the end.
Certification BenchRun::judge_reference() {
  const Layers layers = chain_->read();
  const KeyedCell& mean = chain_->mean();
  ReferenceSettings settings = *plan_.experiment.reference;
  settings.tolerance *= 0.97;
  std::vector<Measurement> rows =
      reference_rows({mean.planned, mean.key.id()}, layers, settings, identity());
  const std::vector<Measurement> errors =
      quick_errors(measured_cells(), layers, identity(), reader());
  rows.insert(rows.end(), errors.begin(), errors.end());
  return *certify(rows);
}

StoredBudget BenchRun::read_budget(const KeyedBudget& budget) {
  ReadCell read = tools_.clock.in(storing_work, [&] { return tools_.store().read(budget.key); });
  if (!read.cell) {
    tools_.warn(read.warning + "; made again");
    converge(budget);
    tools_.writer().flush();
    read = tools_.store().read(budget.key);
    if (!read.cell) throw DeviceError(read.warning + ", twice in a row");
  }
  return {budget.cell, budget.key.id(), std::move(read.cell->layers),
          read.cell->extra.get<Metadata>()};
}

/// The budget of a planned cell; the last one read is kept.
ReadBudget BenchRun::budget_reader() {
  return [this, kept = std::optional<StoredBudget>()](
             const PlannedCell& cell) mutable -> const StoredBudget& {
    const auto found = std::ranges::find_if(plan_.budgets, [&](const KeyedBudget& budget) {
      return find_variant(budget.cell, cell) != nullptr;
    });
    if (!kept || kept->id != found->key.id()) kept.emplace(read_budget(*found));
    return *kept;
  };
}

/// Reads a cell and, on another thread, the next one of the plan ahead: they are asked for in their
/// order, one by one. One that turns out damaged is rendered again, and said so.
ReadLayers BenchRun::reader() {
  return [this](const MeasuredCell& cell) {
    if (chain_ && cell.id == chain_->mean().key.id()) return chain_->read();
    return read_cell(plan_.cells[places_.at(cell.id)]);
  };
}

Layers BenchRun::read_cell(const KeyedCell& cell) {
  const std::string id = cell.key.id();
  ReadCell read = tools_.clock.in(storing_work, [&] {
    tools_.writer().flush();
    return next_id_ == id && next_.valid() ? next_.get() : tools_.store().read(cell.key);
  });
  if (!read.cell) {
    if (!read.warning.empty()) tools_.warn(read.warning + "; rendered again");
    render(cell);
    tools_.writer().flush();
    read = tools_.store().read(cell.key);
    if (!read.cell) throw DeviceError(read.warning + ", twice in a row");
  }
  if (cell.planned.role == Role::test)
    tell(cell.planned.parameters, read.cell->extra.get<Metadata>());
  return std::move(read.cell->layers);
}

/// Cells of one view say the same: once is enough.
void BenchRun::tell(const ParameterSet& parameters, const Metadata& facts) {
  for (std::string& warning : fact_warnings(parameters, facts)) {
    if (told_.insert(warning).second) tools_.warn(std::move(warning));
  }
}

std::vector<MeasuredCell> BenchRun::measured_cells() const {
  std::vector<MeasuredCell> measured;
  for (const KeyedCell& cell : plan_.cells) measured.push_back({cell.planned, cell.key.id()});
  return measured;
}

void BenchRun::measure(const RowSink& sink) {
  tools_.open(plan_);  // for its warnings
  const std::vector<MeasuredCell> cells = measured_cells();
  Progress progress("measuring", cells.size());
  const ReadLayers read = reader();
  const auto begin = [&](std::size_t index) {
    throw_if_interrupted();
    progress.update(index, label(cells[index].planned));
  };
  const auto read_and_look_ahead = [&](const MeasuredCell& cell) {
    Layers layers = read(cell);
    const std::size_t next = places_.at(cell.id) + 1;
    if (next > 1 && next < plan_.cells.size()) {
      next_id_ = cells[next].id;
      // A single thread reads when it gets there.
      next_ = std::async(
          thread_count() > 1 ? std::launch::async : std::launch::deferred,
          [&store = tools_.store(), key = plan_.cells[next].key] { return store.read(key); });
    }
    return layers;
  };
  measure_cells(cells, plan_.experiment.benches.front().regions, identity(), read_and_look_ahead,
                begin, sink);
  if (chain_) {
    sink(reference_rows(cells.front(), chain_->read(), *plan_.experiment.reference, identity()));
    ReferenceSettings as_traced = *plan_.experiment.reference;
    as_traced.max_rays_per_pixel.reset();
    for (std::size_t i = 1; i <= as_traced.others.size(); ++i) {
      sink(reference_rows(cells[i], read(cells[i]), as_traced, identity()));
    }
  }
  for (const KeyedBudget& budget : plan_.budgets) {
    throw_if_interrupted();
    const StoredBudget stored = read_budget(budget);
    const BudgetSettings& settings = *plan_.experiment.budget;
    for (const auto& [name, value] : stored.facts) {
      if (name.ends_with("_reached") && value == "no") {
        tools_.warn(fmt::format("error budget: {} did not reach the tolerance of {} in its {:g} s",
                                name.substr(0, name.size() - std::string("_reached").size()),
                                settings.tolerance, settings.budget_seconds));
      }
    }
    sink(measure_budget(stored, cells, identity(), read_and_look_ahead));
  }
}

FigureBench BenchRun::for_figures() { return {measured_cells(), reader(), budget_reader()}; }

std::vector<KeyedCell> BenchRun::all_cells() const {
  std::vector<KeyedCell> all = plan_.cells;
  if (chain_) std::ranges::copy(chain_->steps(), std::back_inserter(all));
  return all;
}

json BenchRun::report_reference(const std::vector<Measurement>& rows) const {
  std::vector<Measurement> own;
  std::ranges::copy_if(rows, std::back_inserter(own),
                       [this](const Measurement& row) { return is_of(row); });
  json report = to_json(*certify(own));
  report.update(
      {{"cell", chain_->mean().key.id()}, {"parts", chain_->parts()}, {"key", reference_key_}});
  json others = json::array();
  for (std::size_t i = 1; i < plan_.cells.size(); ++i) {
    if (plan_.cells[i].planned.role == Role::reference) others.push_back(plan_.cells[i].key.id());
  }
  if (!others.empty()) report["others"] = std::move(others);
  return report;
}

Measurement BenchRun::identity() const { return shared_facts(plan_, tools_.device()); }

std::string BenchRun::hashes() const {
  std::string text;
  for (const KeyedCell& cell : plan_.cells) text += cell.key.hash();
  for (const KeyedBudget& budget : plan_.budgets) text += budget.key.hash();
  return text;
}

bool BenchRun::is_of(const Measurement& row) const {
  const Measurement own = identity();
  return row.scene == own.scene && row.resolution == own.resolution && row.probe == own.probe &&
         (row.view == own.view || row.view.starts_with(own.view + " ["));
}

bool is_of_certification(const Measurement& row) {
  return row.metric.starts_with("reference_") || (row.metric == "rmse" && row.seed == "all");
}

std::string measuring_key(const Experiment& experiment, const std::string& hashes) {
  return sha256_text(experiment.resolved + std::string(harness_hash) + hashes);
}

}  // namespace occlab
