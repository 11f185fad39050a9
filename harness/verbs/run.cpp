#include "harness/config.h"
#include "harness/runner.h"
#include "harness/verbs/verbs.h"

namespace occlab {
namespace {

struct RunVerbOptions {
  std::string config;
  std::string out;
  std::vector<std::string> overrides;
  RunOptions run;
};

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
  verb->add_flag("--fresh", options->run.fresh, "drop what an earlier run left in the folder");
  verb->callback([options, &action] {
    action = [options] {
      const Experiment experiment = load_experiment(options->config, options->overrides, methods());
      options->run.out = options->out.empty() ? "results/" + experiment.name : options->out;
      run_experiment(experiment, options->run);
      return exit_good;
    };
  });
}

}  // namespace occlab
