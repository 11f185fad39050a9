#include "harness/run_facts.h"

#include <fmt/format.h>

#include "harness/files.h"
#include "harness/version.h"
#include "renderers/methods/method.h"

namespace occlab {

Measurement shared_facts(const BenchPlan& bench, const DeviceInfo& device) {
  Measurement row;
  row.experiment = bench.experiment.name;
  row.scene = bench.scene;
  row.view = bench.facts.view;
  row.resolution =
      fmt::format("{}x{}", bench.facts.resolution.width, bench.facts.resolution.height);
  row.probe = describe(bench.facts.probe);
  row.device = fmt::format("{} ({})", device.renderer, device.software ? "software" : "hardware");
  return row;
}

Measurement shared_facts(const Experiment& experiment, const Workbench& bench) {
  return shared_facts({experiment, bench.scene().name, bench_facts(bench), {}, {}}, bench.device());
}

std::string timing_key_of(const Experiment& experiment, const BenchFacts& facts) {
  std::string text =
      fmt::format("{} {} {} {}", renderers_hash, harness_hash, facts.device, facts.driver);
  text += fmt::format(" {} {} {}", facts.scene_hash, facts.view, facts.probe_hash);
  text += fmt::format(" {}x{} {}", experiment.scene.width, experiment.scene.height,
                      describe(facts.probe));
  if (const auto& timing = experiment.timing) {
    text += fmt::format(" {} {} {}", timing->baseline, timing->repetitions, timing->budget_seconds);
    for (const auto& [name, value] : timing->baseline_at) {
      text += fmt::format(" at {}={}", name, to_string(value));
    }
  }
  for (const TimedCell& timed : plan_timing(experiment, methods())) {
    text += fmt::format(" {} {} {}x{} {}", timed.cell.method, timed.cell.parameters.to_string(),
                        timed.resolution.width, timed.resolution.height, timed.triangles);
    for (const std::string& axis : timed.axes) text += " " + axis;
  }
  return sha256_text(text);
}

}  // namespace occlab
