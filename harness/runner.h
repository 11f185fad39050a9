#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "harness/config.h"
#include "harness/shards.h"

namespace occlab {

struct RunOptions {
  std::filesystem::path out;  ///< the results folder
  std::string device = "auto";
  bool fresh = false;  ///< drops what an earlier run left in the folder
  /// Only this part of the missing cells, and nothing is measured: a run without it does that.
  std::optional<Shard> shard;
  std::optional<double> cell_seconds;  ///< a cell that takes longer ends the process (cell_watch.h)
};

/// Renders what is missing, measures, times and writes tables and figures:
///
///     OUT/cells/ID/         one finished cell each (store.h)
///     OUT/measurements.csv  every number, tidy
///     OUT/run.json          experiment, commit, device, versions, hashes, warnings, timing context
///     OUT/tables/           Markdown, CSV, JSON and LaTeX
///     OUT/figures/          PNG
///     OUT/progress/         what 'occlab status' shows (work_log.h)
///
/// Several processes, on several machines, may share the folder, each with a shard or none; what
/// one is working on the others leave to it (shared_work.h). A second run over the same folder does
/// only what is not done yet. Progress goes to stderr, the tables to stdout. Throws InputError,
/// DeviceError and Interrupted; finished cells stay.
void run_experiment(const Experiment& experiment, const RunOptions& options);

}  // namespace occlab
