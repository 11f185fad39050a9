#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "harness/environment_report.h"
#include "harness/experiment_tables.h"
#include "harness/files.h"
#include "harness/scaling_figures.h"
#include "harness/table_layout.h"
#include "harness/timing.h"
#include "harness/verbs/verbs.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

namespace fs = std::filesystem;

struct TimeOptions {
  std::string config;
  std::string out;
  std::vector<std::string> overrides;
  std::string device = "auto";
  bool json = false;
};

/// A folder with more in it than times would be left with measurements that nothing describes.
void refuse_other_results(const fs::path& folder) {
  if (folder.empty() || !fs::exists(folder / "cells")) return;
  throw InputError(fmt::format(
      "--out {}: holds the cells of an 'occlab run'; accepted is another folder", folder.string()));
}

void store(const fs::path& folder, const std::vector<Measurement>& measurements,
           const std::vector<Table>& tables, nlohmann::json report) {
  create_folder(folder);
  const fs::path path = folder / "measurements.csv";
  write_measurements(path, measurements);
  write_tables(tables, folder / "tables");
  report["measurements_sha256"] = sha256_file(path);
  write_text_atomically(folder / "run.json", report.dump(2) + "\n");
}

ExitCode time(const TimeOptions& options) {
  const Experiment experiment = load_experiment(options.config, options.overrides, methods());
  if (!experiment.timing) {
    throw InputError(fmt::format("{}: key 'timing': missing; 'occlab time' needs a table [timing]",
                                 experiment.file.string()));
  }
  refuse_other_results(options.out);
  nlohmann::json report;
  const TimingResult result = time_experiment(
      experiment, options.device,
      [&](const Workbench& bench) { report = environment_report(experiment, bench); });
  const TimingTableSettings settings = timing_table_settings(experiment, result.context);
  const std::vector<Table> tables = make_timing_tables(result.measurements, settings);
  report["timing"] = result.context;
  report["timing_table"] = to_json(settings);
  if (!options.out.empty()) {
    store(options.out, result.measurements, tables, report);
    write_scaling_figures(result.measurements, fs::path(options.out) / "figures");
  }
  print_tables(tables, options.json ? "json" : "md");
  return exit_good;
}

}  // namespace

void add_time_verb(CLI::App& app, Action& action) {
  auto options = std::make_shared<TimeOptions>();
  CLI::App* verb = app.add_subcommand(
      "time", "time what an experiment's [timing] says, and nothing else; print the tables");
  verb->add_option("config", options->config, "the experiment file (configs/FORMAT.md)")
      ->required();
  verb->add_option("--out", options->out,
                   "a folder for measurements.csv, run.json, tables and figures; default: none");
  verb->add_option("--set", options->overrides,
                   "KEY=VALUE, dotted, as in the file: timing.repetitions=15");
  verb->add_option("--device", options->device, "see 'occlab list devices'")->capture_default_str();
  verb->add_flag("--json", options->json, "print the tables as JSON");
  verb->callback([options, &action] { action = [options] { return time(*options); }; });
}

}  // namespace occlab
