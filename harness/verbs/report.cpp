#include <fmt/format.h>

#include "harness/report/writer.h"
#include "harness/verbs/verbs.h"
#include "renderers/scene/error.h"

namespace occlab {

void add_report_verb(CLI::App& app, Action& action) {
  auto options = std::make_shared<report::ReportOptions>();
  CLI::App* verb = app.add_subcommand(
      "report", "write RESULTS/report/index.html: tables, figures, images and plots to look at");
  verb->add_option("results", options->results, "the folder of an 'occlab run'")->required();
  verb->add_option("--megabytes", options->megabytes,
                   "how large the report may be; the images that fit are chosen by this")
      ->check(CLI::Range(1.0, 1e5))
      ->capture_default_str();
  verb->callback([options, &action] {
    action = [options] {
      const report::WrittenReport written = report::write_report(*options);
      for (const std::string& problem : written.problems) {
        fmt::print(stderr, "occlab: {}\n", problem);
      }
      for (const std::string& left_out : written.left_out) {
        fmt::print(stderr, "occlab: left out, --megabytes {:g} is too little: {}\n",
                   options->megabytes, left_out);
      }
      fmt::print("{}: {:.1f} MB\n", written.index.string(), double(written.bytes) * 1e-6);
      return exit_good;
    };
  });
}

}  // namespace occlab
