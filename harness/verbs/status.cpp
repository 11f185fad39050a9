#include "harness/status.h"

#include <fmt/format.h>

#include <cstdio>

#include "harness/verbs/verbs.h"
#include "renderers/scene/error.h"

namespace occlab {

void add_status_verb(CLI::App& app, Action& action) {
  struct Options {
    std::string results;
    bool as_json = false;
    bool rendered = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand(
      "status", "how far a run is: its cells, its shards, what failed, how long it will take");
  verb->add_option("results", options->results, "the results folder of the run")->required();
  verb->add_flag("--json", options->as_json, "as JSON");
  verb->add_flag("--rendered", options->rendered, "exit with 1 while any of its cells is missing");
  verb->callback([options, &action] {
    action = [options] {
      const RunStatus status = read_status(options->results);
      fmt::print("{}", options->as_json ? to_json(status).dump(2) + "\n" : status_text(status));
      if (!options->rendered || (status.planned > 0 && status.done == status.planned)) {
        return exit_good;
      }
      std::fflush(stdout);  // the reason is the last line of a job's log
      fmt::print(stderr, "occlab: {}: {} of {} cells are rendered\n", options->results, status.done,
                 status.planned);
      return exit_check_failed;
    };
  });
}

}  // namespace occlab
