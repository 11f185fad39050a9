#include <fmt/format.h>

#include "harness/config.h"
#include "harness/forecast.h"
#include "harness/runner.h"
#include "harness/table_layout.h"
#include "harness/verbs/executor.h"
#include "harness/verbs/verbs.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

struct RunVerbOptions {
  std::string config;
  std::string out;
  std::optional<std::string> shard;
  std::vector<std::string> overrides;
  RunOptions run;
  ExecutorOptions executor;
  bool dry_run = false;
  bool json = false;
};

void print_forecast(const Experiment& experiment, const RunVerbOptions& options) {
  const auto stored = index_cells(options.run.out);
  const PlannedDevice device = planned_device(options.run.device, stored);
  const std::vector<BenchPlan> benches = plan_without_context(experiment, device);
  const Forecast found = forecast(benches, device, stored);
  if (options.json) {
    fmt::print("{}\n", forecast_json(found).dump(2));
  } else {
    print_table(forecast_table(found), "md");
  }
}

}  // namespace

void add_run_verb(CLI::App& app, Action& action) {
  auto options = std::make_shared<RunVerbOptions>();
  CLI::App* verb = app.add_subcommand(
      "run", "render, measure, time and tabulate an experiment; goes on where it was interrupted");
  verb->add_option("config", options->config, "the experiment file (configs/FORMAT.md)")
      ->required();
  verb->add_option("--out", options->out, "the results folder; default: results/NAME");
  verb->add_option("--set", options->overrides,
                   "KEY=VALUE, dotted, as in the file: run[0].seeds=2");
  verb->add_option("--device", options->run.device, "see 'occlab list devices'")
      ->capture_default_str();
  CLI::Option* dry_run = verb->add_flag(
      "--dry-run", options->dry_run,
      "render nothing: print the cells, which are finished, and what the others may take");
  verb->add_flag("--json", options->json, "print the dry run as JSON")->needs(dry_run);
  CLI::Option* fresh =
      verb->add_flag("--fresh", options->run.fresh, "drop what an earlier run left in the folder");
  verb->add_option("--shard", options->shard,
                   "I/N: render the I-th of N parts of the missing cells (I from 1) and do not "
                   "measure; when all parts are done the same command without it does")
      ->excludes(fresh)
      ->excludes(dry_run);
  fresh->excludes(dry_run);
  verb->add_option("--cell-time-limit", options->run.cell_seconds,
                   "seconds after which a cell that is not finished ends the run, such as one "
                   "whose shader hangs; default: none")
      ->check(CLI::PositiveNumber);
  add_executor_options(*verb, options->executor);
  verb->callback([options, &action] {
    action = [options] {
      const Experiment experiment = load_experiment(options->config, options->overrides, methods());
      if (options->shard) options->run.shard = parse_shard(*options->shard);
      options->run.out = options->out.empty() ? "results/" + experiment.name : options->out;
      const bool cluster = on_cluster(options->executor);
      if (options->dry_run && cluster) {
        throw InputError(
            "--dry-run: nothing is submitted; accepted is one of it and --executor slurm");
      }
      if (options->dry_run) {
        print_forecast(experiment, *options);
      } else if (cluster) {
        run_on_cluster(experiment, options->run.out, options->executor);
      } else {
        run_experiment(experiment, options->run);
      }
      return exit_good;
    };
  });
}

}  // namespace occlab
