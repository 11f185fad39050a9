#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "harness/config.h"
#include "harness/forecast.h"
#include "harness/table_layout.h"
#include "harness/verbs/verbs.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

using nlohmann::json;
using Stored = std::map<std::string, CellDescription>;

struct WhyOptions {
  std::string config;
  std::string cell;
  std::string out;
  std::vector<std::string> overrides;
  std::string device = "auto";
  bool json = false;
};

/// Why a planned cell is not there: the stored cell that is most like it, and what differs.
struct Reason {
  std::string id;    ///< of the planned cell
  std::string what;  ///< label()
  bool finished = false;
  std::string nearest;  ///< the stored cell's id; "": nothing is stored
  std::vector<FactDifference> differences;
};

Reason reason_of(const ForecastCell& cell, const Stored& stored) {
  Reason reason{cell.key().id(), cell.what, cell.finished, "", {}};
  if (cell.finished) return reason;
  if (const CellDescription* nearest = nearest_cell(stored, cell.key())) {
    reason.nearest = nearest->id;
    reason.differences = differences(*nearest, cell.key());
  }
  return reason;
}

json to_json(const Reason& reason) {
  json facts = json::array();
  for (const FactDifference& fact : reason.differences) {
    facts.push_back({{"name", fact.name}, {"stored", fact.stored}, {"wanted", fact.wanted}});
  }
  return {{"cell", reason.id},
          {"what", reason.what},
          {"finished", reason.finished},
          {"nearest", reason.nearest.empty() ? json() : json(reason.nearest)},
          {"differences", facts}};
}

std::string sentence(const Reason& reason) {
  if (reason.finished) {
    return fmt::format("cell {} ({}) is up to date: it would not be rendered again", reason.id,
                       reason.what);
  }
  if (reason.nearest.empty()) {
    return fmt::format("cell {} ({}) would be rendered: nothing is stored", reason.id, reason.what);
  }
  return fmt::format("cell {} ({}) would be rendered: the stored cell most like it, {}, differs in",
                     reason.id, reason.what, reason.nearest);
}

Table differences_table(const Reason& reason) {
  Table table{.name = "why",
              .title = sentence(reason),
              .columns = {{.name = "fact", .unit = ""},
                          {.name = "stored", .unit = ""},
                          {.name = "wanted", .unit = ""}},
              .rows = {},
              .notes = {}};
  for (const FactDifference& fact : reason.differences) {
    table.rows.push_back({fact.name, fact.stored, fact.wanted});
  }
  return table;
}

std::string names_of(const std::vector<FactDifference>& differences) {
  std::vector<std::string> names;
  for (const FactDifference& fact : differences) names.push_back(fact.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// One row for each set of facts that keeps cells from being there.
Table summary_table(const std::vector<Reason>& reasons, const std::string& folder) {
  struct Kind {
    std::size_t cells = 0;
    const Reason* example = nullptr;
  };
  std::map<std::string, Kind> kinds;
  std::size_t finished = 0;
  for (const Reason& reason : reasons) {
    if (reason.finished) {
      ++finished;
      continue;
    }
    Kind& kind = kinds[reason.nearest.empty() ? "nothing is stored" : names_of(reason.differences)];
    if (kind.cells++ == 0) kind.example = &reason;
  }
  Table table{.name = "why",
              .title = fmt::format("Why cells of {} would be rendered", folder),
              .columns = {{.name = "what differs from the nearest stored cell", .unit = ""},
                          {.name = "cells", .unit = "", .alignment = Alignment::right},
                          {.name = "such as", .unit = ""},
                          {.name = "which is", .unit = ""}},
              .rows = {},
              .notes = {fmt::format("{} of {} cells are up to date", finished, reasons.size())}};
  for (const auto& [names, kind] : kinds) {
    table.rows.push_back(
        {names, TableNumber{double(kind.cells), {}, {}}, kind.example->id, kind.example->what});
  }
  return table;
}

/// The planned cell whose id begins so.
const ForecastCell& find_cell(const Forecast& found, const std::string& id, const Stored& stored,
                              const std::string& folder) {
  const ForecastCell* match = nullptr;
  for (const ForecastCell& cell : found.cells) {
    if (!cell.key().id().starts_with(id)) continue;
    if (match)
      throw InputError(fmt::format("cell {}: several cells begin so; give more digits", id));
    match = &cell;
  }
  if (match) return *match;
  const bool known =
      std::ranges::any_of(stored, [&](const auto& entry) { return entry.first.starts_with(id); });
  throw InputError(
      known ? fmt::format("cell {}: stored in {}, but the experiment does not make it (any more); "
                          "'occlab run CONFIG --dry-run' lists what it makes",
                          id, folder)
            : fmt::format("cell {}: the experiment makes no such cell; 'occlab run CONFIG "
                          "--dry-run' lists them",
                          id));
}

int why(const WhyOptions& options) {
  const Experiment experiment = load_experiment(options.config, options.overrides, methods());
  const std::string folder = options.out.empty() ? "results/" + experiment.name : options.out;
  const Stored stored = index_cells(folder);
  const PlannedDevice device = planned_device(options.device, stored);
  const std::vector<BenchPlan> benches = plan_without_context(experiment, device);
  const Forecast found = forecast(benches, device, stored);
  if (!options.cell.empty()) {
    if (stored.empty()) {
      throw InputError(fmt::format("cell {}: nothing is stored in {}", options.cell, folder));
    }
    const Reason reason = reason_of(find_cell(found, options.cell, stored, folder), stored);
    if (options.json) {
      fmt::print("{}\n", to_json(reason).dump(2));
    } else if (reason.differences.empty()) {
      fmt::print("{}\n", sentence(reason));
    } else {
      print_table(differences_table(reason), "md");
    }
    return exit_good;
  }
  std::vector<Reason> reasons;
  for (const ForecastCell& cell : found.cells) reasons.push_back(reason_of(cell, stored));
  if (options.json) {
    json list = json::array();
    for (const Reason& reason : reasons) list.push_back(to_json(reason));
    fmt::print("{}\n", list.dump(2));
    return exit_good;
  }
  Table table = summary_table(reasons, folder);
  table.notes.push_back(device.note);
  print_table(table, "md");
  return exit_good;
}

}  // namespace

void add_why_verb(CLI::App& app, Action& action) {
  auto options = std::make_shared<WhyOptions>();
  CLI::App* verb = app.add_subcommand(
      "why", "say why cells of an experiment would be rendered (again): which facts have changed");
  verb->add_option("config", options->config, "the experiment file (configs/FORMAT.md)")
      ->required();
  verb->add_option("cell", options->cell, "a cell's id or its beginning; default: all, in short");
  verb->add_option("--out", options->out, "the results folder; default: results/NAME");
  verb->add_option("--set", options->overrides, "KEY=VALUE, as 'occlab run' takes it");
  verb->add_option("--device", options->device,
                   "see 'occlab list devices'; auto: that of the stored cells")
      ->capture_default_str();
  verb->add_flag("--json", options->json, "print it as JSON");
  verb->callback([options, &action] { action = [options] { return why(*options); }; });
}

}  // namespace occlab
