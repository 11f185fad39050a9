#pragma once

#include <filesystem>
#include <string>

#include "harness/config.h"

namespace occlab {

struct RunOptions {
  std::filesystem::path out;  ///< the results folder
  std::string device = "auto";
  bool fresh = false;  ///< drops what an earlier run left in the folder
};

/// Renders what is missing, measures, times and writes tables and figures:
///
///     OUT/cells/ID/         one finished cell each (store.h)
///     OUT/measurements.csv  every number, tidy
///     OUT/run.json          experiment, commit, device, versions, hashes, warnings, timing context
///     OUT/tables/           Markdown, CSV, JSON and LaTeX
///     OUT/figures/          PNG
///
/// A second run over the same folder does only what is not done yet. Progress goes to stderr, the
/// tables to stdout. Throws InputError, DeviceError and Interrupted; finished cells stay.
void run_experiment(const Experiment& experiment, const RunOptions& options);

}  // namespace occlab
