#include "harness/forecast.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <map>
#include <optional>
#include <sstream>

#include "harness/shards.h"
#include "renderers/gl/context.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

using nlohmann::json;
using Stored = std::map<std::string, CellDescription>;

std::optional<double> stored_seconds(const CellDescription& cell) {
  const auto text = cell.extra.find("wall_seconds");
  if (text == cell.extra.end() || !text->is_string()) return std::nullopt;
  const auto& digits = text->get_ref<const std::string&>();
  double seconds = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), seconds);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  return seconds;
}

/// What the model says of a finished cell; nothing for a budget, and for a method or parameters of
/// another version.
std::optional<double> model_seconds(const CellDescription& cell) {
  const std::string* const method = cell.fact("method");
  const std::string* const parameters = cell.fact("parameters");
  const std::string* const resolution = cell.fact("resolution");
  if (!method || !parameters || !resolution) return std::nullopt;
  int width = 0;
  int height = 0;
  if (std::sscanf(resolution->c_str(), "%dx%d", &width, &height) != 2) return std::nullopt;
  try {
    PlannedCell planned{Role::test, *method, ParameterSet(find_method(*method).parameters), 0};
    std::istringstream words(*parameters);
    for (std::string word; words >> word;) {
      const std::size_t equals = word.find('=');
      if (equals == std::string::npos) return std::nullopt;
      planned.parameters.set_text(word.substr(0, equals), word.substr(equals + 1));
    }
    return estimated_seconds(planned, width, height);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

struct Calibration {
  double measured = 0.0;
  double model = 0.0;
  std::size_t cells = 0;

  double factor() const { return measured / model; }
};

/// How the finished cells of each method, and of "" all of them, compare with the model.
std::map<std::string, Calibration> calibrate(const Stored& stored, const std::string& device) {
  std::map<std::string, Calibration> found;
  for (const auto& [id, cell] : stored) {
    const std::string* const method = cell.fact("method");
    const std::string* const renderer = cell.fact("device");
    if (!method || !renderer || *renderer != device) continue;
    const std::optional<double> seconds = stored_seconds(cell);
    const std::optional<double> model = model_seconds(cell);
    if (!seconds || !model || !(*model > 0.0)) continue;
    for (const std::string& name : {*method, std::string()}) {
      Calibration& sums = found[name];
      sums.measured += *seconds;
      sums.model += *model;
      ++sums.cells;
    }
  }
  std::erase_if(found, [](const auto& entry) { return !(entry.second.measured > 0.0); });
  return found;
}

void add_notes(Forecast& result, const std::map<std::string, Calibration>& calibrations,
               const std::vector<BenchPlan>& benches) {
  if (calibrations.empty()) {
    result.notes.emplace_back(
        "seconds: a model of march steps, rays and pixels on two cores of a software rasteriser; "
        "no finished cell says how long it took");
  }
  for (const auto& [method, sums] : calibrations) {
    if (method.empty()) continue;
    result.notes.push_back(
        fmt::format("seconds of {}: the model times {:.2f}, as {} finished "
                    "cells took",
                    method, sums.factor(), sums.cells));
  }
  result.notes.emplace_back("not in it: opening scenes, measuring, timing, tables and figures");
  for (const BenchPlan& bench : benches) {
    const auto& reference = bench.experiment.reference;
    if (!reference || !reference->max_rays_per_pixel) continue;
    result.notes.push_back(
        fmt::format("the reference may be given more rays, up to {} a pixel, which is not in it "
                    "either",
                    *reference->max_rays_per_pixel));
    break;
  }
}

}  // namespace

PlannedDevice planned_device(const std::string& device, const Stored& stored) {
  if (device != "auto") {
    const Context context(device);
    return {context.info().renderer, context.info().version,
            fmt::format("device: {}, opened for this", context.info().renderer)};
  }
  std::map<std::pair<std::string, std::string>, std::size_t> counts;
  for (const auto& [id, cell] : stored) {
    const std::string* const renderer = cell.fact("device");
    const std::string* const driver = cell.fact("driver");
    if (renderer && driver) ++counts[{*renderer, *driver}];
  }
  if (counts.empty()) {
    return {"", "",
            "nothing is stored, so that the device does not matter; none was opened, and "
            "without one cells have no ids"};
  }
  const auto most =
      std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; });
  return {most->first.first, most->first.second,
          fmt::format("device: none was opened; taken for that of {} of {} stored cells, {} ({}); "
                      "on another one all would be rendered: --device says which",
                      most->second, stored.size(), most->first.first, most->first.second)};
}

std::vector<BenchPlan> plan_without_context(const Experiment& experiment,
                                            const PlannedDevice& device) {
  std::optional<LoadedScene> scene;
  return plan_benches(experiment, device.renderer, device.driver,
                      [&](const std::string& source) -> const LoadedScene& {
                        if (!scene || scene->source != source) {
                          scene.reset();
                          scene.emplace(load(source));
                        }
                        return *scene;
                      });
}

std::size_t Forecast::finished() const {
  return std::size_t(std::ranges::count(cells, true, &ForecastCell::finished));
}

double Forecast::seconds_to_do() const {
  double sum = 0.0;
  for (const ForecastCell& cell : cells) sum += cell.finished ? 0.0 : cell.seconds;
  return sum;
}

Forecast forecast(const std::vector<BenchPlan>& benches, const PlannedDevice& device,
                  const Stored& stored) {
  const std::map<std::string, Calibration> calibrations = calibrate(stored, device.renderer);
  const auto factor_of = [&](const std::string& method) {
    const auto own = calibrations.find(method);
    const auto any = calibrations.find("");
    return own != calibrations.end()   ? own->second.factor()
           : any != calibrations.end() ? any->second.factor()
                                       : 1.0;
  };
  Forecast result;
  const auto add = [&](ForecastCell cell, double estimate) {
    cell.seconds = estimate;
    const auto known = stored.find(cell.key().id());
    if (known != stored.end() && known->second.facts == cell.key().facts()) {
      cell.finished = true;
      if (const auto seconds = stored_seconds(known->second)) {
        cell.seconds = *seconds;
        cell.measured = true;
      }
    }
    result.cells.push_back(std::move(cell));
  };
  for (const BenchPlan& bench : benches) {
    const auto& [width, height] = bench.facts.resolution;
    for (const KeyedCell& cell : bench.cells) {
      add({.bench = &bench, .cell = &cell, .what = label(cell.planned)},
          factor_of(cell.planned.method) * estimated_seconds(cell.planned, width, height));
    }
    for (const KeyedBudget& budget : bench.budgets) {
      add({.bench = &bench, .budget = &budget, .what = label(budget.cell)},
          estimated_seconds(budget.cell, *bench.experiment.budget, width, height));
    }
  }
  result.notes.push_back(device.note);
  add_notes(result, calibrations, benches);
  return result;
}

namespace {

using NamedTexts = std::vector<std::pair<std::string, std::string>>;

/// What a cell is called by, without its id.
NamedTexts facts_of(const ForecastCell& cell) {
  const BenchFacts& facts = cell.bench->facts;
  NamedTexts texts = {
      {"scene", cell.bench->scene},
      {"view", facts.view},
      {"resolution", fmt::format("{}x{}", facts.resolution.width, facts.resolution.height)},
      {"probe", describe(facts.probe)}};
  if (!cell.cell) {
    texts.emplace_back("method", cell.what);
    return texts;
  }
  texts.emplace_back("method", cell.cell->planned.method);
  for (auto& parameter : named_parameters(cell.cell->planned.parameters)) {
    texts.push_back(std::move(parameter));
  }
  const ParameterSet& parameters = cell.cell->planned.parameters;
  if (parameters.has("seed")) {
    texts.emplace_back("seed", to_string(parameters.value("seed")));
  }
  return texts;
}

}  // namespace

Table forecast_table(const Forecast& forecast) {
  Table table{.name = "cells", .title = "Cells", .columns = {}, .rows = {}, .notes = {}};
  std::vector<NamedTexts> all;
  std::vector<std::string> names;
  std::map<std::string, std::pair<std::string, bool>> values;  // the first, and whether it varies
  for (const ForecastCell& cell : forecast.cells) {
    all.push_back(facts_of(cell));
    merge_names(names, all.back());
    for (const auto& [name, value] : all.back()) {
      const auto [known, is_new] = values.try_emplace(name, value, false);
      if (!is_new && known->second.first != value) known->second.second = true;
    }
  }
  std::erase_if(
      names, [&](const std::string& name) { return name != "method" && !values.at(name).second; });
  table.columns.push_back({.name = "cell", .unit = ""});
  for (const std::string& name : names) table.columns.push_back({.name = name, .unit = ""});
  table.columns.push_back({.name = "state", .unit = ""});
  table.columns.push_back({.name = "time", .unit = "s", .alignment = Alignment::right});
  for (std::size_t i = 0; i < all.size(); ++i) {
    const ForecastCell& cell = forecast.cells[i];
    std::vector<TableCell> row = {cell.bench->facts.device.empty() ? std::string()
                                                                   : cell.key().id()};
    for (const std::string& name : names) {
      const auto found = std::ranges::find(all[i], name, &NamedTexts::value_type::first);
      row.emplace_back(found == all[i].end() ? std::string() : found->second);
    }
    row.emplace_back(std::string(cell.finished ? "finished" : "to render"));
    row.emplace_back(TableNumber{cell.seconds, {}, {}});
    table.rows.push_back(std::move(row));
  }
  table.notes.push_back(fmt::format(
      "{} cells, {} finished, {} to render in about {:.1f} s", forecast.cells.size(),
      forecast.finished(), forecast.cells.size() - forecast.finished(), forecast.seconds_to_do()));
  table.notes.insert(table.notes.end(), forecast.notes.begin(), forecast.notes.end());
  return table;
}

json forecast_json(const Forecast& forecast) {
  json cells = json::array();
  for (const ForecastCell& cell : forecast.cells) {
    json entry = {{"id", cell.bench->facts.device.empty() ? json() : json(cell.key().id())},
                  {"finished", cell.finished},
                  {"seconds", cell.seconds},
                  {"seconds_from", cell.measured ? "measured" : "estimated"}};
    for (const auto& [name, value] : facts_of(cell)) {
      const bool own = name == "scene" || name == "view" || name == "resolution" ||
                       name == "probe" || name == "method";
      if (own) {
        entry[name] = value;
      } else {
        entry["parameters"][name] = value;
      }
    }
    cells.push_back(std::move(entry));
  }
  return {{"cells", cells},
          {"finished", forecast.finished()},
          {"to_render", forecast.cells.size() - forecast.finished()},
          {"seconds_to_render", forecast.seconds_to_do()},
          {"notes", forecast.notes}};
}

}  // namespace occlab
