#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "harness/config.h"

namespace occlab {

/// Where 'occlab run' runs.
struct ExecutorOptions {
  std::string executor = "local";
  std::optional<std::string> settings;  ///< a file with a table [slurm]
  std::optional<std::string> partition;
  std::optional<std::string> time;
  std::optional<std::string> gpus;
  std::optional<std::size_t> shards;
  std::optional<std::size_t> at_once;
  std::vector<std::string> options;
  bool wait = false;
};

/// Adds --executor and what belongs to it.
void add_executor_options(CLI::App& verb, ExecutorOptions& options);

/// Whether a cluster is asked for. Throws InputError where only its options are.
bool on_cluster(const ExecutorOptions& options);

/// Submits this process's own command line to the cluster. Throws as submit() and wait_for_jobs().
void run_on_cluster(const Experiment& experiment, const std::filesystem::path& results,
                    const ExecutorOptions& options);

/// The command line without the options of the executor and with the program's own path in front.
/// `known` are their names with whether each has a value.
std::vector<std::string> without_options(const std::vector<std::string>& command,
                                         const std::vector<std::pair<std::string, bool>>& known);

}  // namespace occlab
