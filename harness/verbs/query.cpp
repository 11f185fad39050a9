#include <fmt/format.h>

#include "harness/history/measurement_index.h"
#include "harness/table_formats.h"
#include "harness/table_layout.h"
#include "harness/verbs/verbs.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

struct QueryOptions {
  std::string results;
  std::vector<std::string> where;
  std::string format = "md";
  std::size_t limit = 1'000'000;
  bool rebuild = false;
};

std::vector<history::MeasurementIndex::Condition> conditions(const QueryOptions& options) {
  std::vector<history::MeasurementIndex::Condition> found;
  for (const std::string& text : options.where) {
    const std::size_t equals = text.find('=');
    if (equals == 0 || equals == std::string::npos) {
      throw InputError(
          fmt::format("--where {}: accepted is NAME=VALUE, such as metric=rmse", text));
    }
    found.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  return found;
}

}  // namespace

void add_query_verb(CLI::App& app, Action& action) {
  auto options = std::make_shared<QueryOptions>();
  CLI::App* verb = app.add_subcommand(
      "query", "print measurements of a results folder, through an index that is made when needed");
  verb->add_option("results", options->results, "the folder of an 'occlab run' or 'occlab time'")
      ->required();
  verb->add_option("--where", options->where,
                   "NAME=VALUE: a column of measurements.csv, such as metric, method, stage, seed "
                   "or samples, and what it is to be; may be repeated");
  verb->add_option("--limit", options->limit, "rows at most")->capture_default_str();
  verb->add_flag("--rebuild", options->rebuild, "make the index again");
  verb->add_option("--format", options->format, "the format to print")
      ->check(CLI::IsMember(table_formats()))
      ->capture_default_str();
  verb->callback([options, &action] {
    action = [options] {
      const auto wanted = conditions(*options);
      const history::MeasurementIndex index(options->results, options->rebuild);
      print_table(index.query(wanted, options->limit), options->format);
      return exit_good;
    };
  });
}

}  // namespace occlab
