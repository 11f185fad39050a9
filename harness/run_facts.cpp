#include "harness/run_facts.h"

#include <fmt/format.h>

#include "harness/files.h"
#include "harness/version.h"
#include "renderers/methods/method.h"

namespace occlab {

Measurement shared_facts(const Experiment& experiment, const Workbench& bench) {
  Measurement row;
  row.experiment = experiment.name;
  row.scene = bench.scene().name;
  row.view = bench.frame().view.camera.name;
  row.resolution = fmt::format("{}x{}", experiment.scene.width, experiment.scene.height);
  row.probe = describe(bench.probe());
  row.device = fmt::format("{} ({})", bench.device().renderer,
                           bench.device().software ? "software" : "hardware");
  return row;
}

std::string timing_key_of(const Experiment& experiment, const Workbench& bench) {
  std::string text = fmt::format("{} {} {} {}", renderers_hash, harness_hash,
                                 bench.device().renderer, bench.device().version);
  text += fmt::format(" {} {} {}", bench.scene_hash(), bench.frame().view.camera.name,
                      bench.probe_hash());
  text += fmt::format(" {}x{} {}", experiment.scene.width, experiment.scene.height,
                      describe(bench.probe()));
  if (const auto& timing = experiment.timing) {
    text += fmt::format(" {} {} {}", timing->baseline, timing->repetitions, timing->budget_seconds);
  }
  for (const TimedCell& timed : plan_timing(experiment, methods())) {
    text += fmt::format(" {} {} {}x{} {}", timed.cell.method, timed.cell.parameters.to_string(),
                        timed.resolution.width, timed.resolution.height, timed.triangles);
    for (const std::string& axis : timed.axes) text += " " + axis;
  }
  return sha256_text(text);
}

}  // namespace occlab
