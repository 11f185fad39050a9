#include "harness/bench_plan.h"

#include <fmt/format.h>

#include <map>

namespace occlab {

BenchPlan plan_bench(Experiment experiment, std::string scene, BenchFacts facts) {
  BenchPlan bench{std::move(experiment), std::move(scene), std::move(facts), {}, {}};
  std::vector<PlannedCell> cells = plan(bench.experiment, methods());
  if (bench.experiment.budget) {
    for (BudgetCell& cell : plan_budget(cells)) {
      CellKey key = budget_key(bench_key(bench.facts), cell, *bench.experiment.budget);
      bench.budgets.push_back({std::move(cell), std::move(key)});
    }
  }
  for (PlannedCell& cell : cells) {
    CellKey key = cell_key(bench.facts, cell);
    bench.cells.push_back({std::move(cell), std::move(key)});
  }
  return bench;
}

std::vector<BenchPlan> plan_benches(const Experiment& experiment, const std::string& device,
                                    const std::string& driver, const SceneSource& scenes) {
  std::vector<BenchPlan> benches;
  std::map<std::string, std::string> probe_hashes;
  for (const BenchSettings& settings : experiment.benches) {
    Experiment one = at_bench(experiment, settings);
    const ViewSettings view = view_settings(one);
    const LoadedScene& loaded = scenes(view.scene);
    BenchFacts facts;
    facts.scene_hash = loaded.hash;
    facts.view = find_camera(loaded.scene, view.view).name;
    facts.resolution = {view.width, view.height};
    facts.probe = probe_of(view, loaded.scene);
    const auto [hash, is_new] = probe_hashes.try_emplace(facts.probe.source);
    if (is_new) {
      // Loading says what is wrong with a probe; that its filter takes time does not matter here.
      if (!facts.probe.source.empty()) load_environment({.source = facts.probe.source});
      hash->second = hash_probe(facts.probe);
    }
    facts.probe_hash = hash->second;
    facts.device = device;
    facts.driver = driver;
    benches.push_back(plan_bench(std::move(one), loaded.scene.name, std::move(facts)));
  }
  return benches;
}

ViewSettings view_settings(const Experiment& experiment) {
  return {.scene = experiment.scene.source,
          .view = experiment.scene.view,
          .width = experiment.scene.width,
          .height = experiment.scene.height,
          .probe = experiment.probe};
}

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

}  // namespace occlab
