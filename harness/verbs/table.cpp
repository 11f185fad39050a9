#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "harness/experiment_tables.h"
#include "harness/files.h"
#include "harness/table_formats.h"
#include "harness/table_layout.h"
#include "harness/verbs/verbs.h"
#include "renderers/scene/error.h"
#include "renderers/scene/limited_json.h"

namespace occlab {
namespace {

struct TableOptions {
  std::string results;
  std::string format = "md";
};

TimingTableSettings read_timing_settings(const std::filesystem::path& path) {
  const auto report = parse_limited_json_or_discard(read_text(path));
  if (!report.is_object() || !report.contains("timing_table")) {
    throw InputError(fmt::format(
        "{}: key 'timing_table': missing; was it written by 'occlab run' or 'occlab time'?",
        path.string()));
  }
  return stored_timing_table_settings(report["timing_table"]);
}

}  // namespace

void add_table_verb(CLI::App& app, Action& action) {
  auto options = std::make_shared<TableOptions>();
  CLI::App* verb = app.add_subcommand("table", "print the tables of a results folder");
  verb->add_option("results", options->results, "the folder of an 'occlab run' or 'occlab time'")
      ->required();
  verb->add_option("--format", options->format, "the format to print")
      ->check(CLI::IsMember(table_formats()))
      ->capture_default_str();
  verb->callback([options, &action] {
    action = [options] {
      const std::filesystem::path folder = options->results;
      const auto measurements = read_measurements(folder / "measurements.csv");
      const auto settings = read_timing_settings(folder / "run.json");
      print_tables(make_tables(measurements, settings), options->format);
      return exit_good;
    };
  });
}

}  // namespace occlab
