#include "harness/report/cells.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "harness/files.h"
#include "renderers/methods/method.h"
#include "renderers/scene/error.h"
#include "renderers/scene/limited_json.h"
#include "renderers/scene/parallel.h"

namespace occlab::report {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr int cell_format = 1;

std::string text_of(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

/// The facts of cell.json; nothing where they are not pairs of texts.
std::optional<NamedTexts> facts_of(const json& description) {
  NamedTexts facts;
  const auto found = description.find("facts");
  if (found == description.end() || !found->is_array()) return std::nullopt;
  for (const json& fact : *found) {
    if (!fact.is_array() || fact.size() != 2 || !fact[0].is_string() || !fact[1].is_string()) {
      return std::nullopt;
    }
    facts.emplace_back(fact[0].get<std::string>(), fact[1].get<std::string>());
  }
  return facts;
}

/// What is wrong with layers.exr, "" if nothing is.
std::string check_pixels(const fs::path& exr, const json& description) {
  const auto stated = description.find("layers.exr");
  if (stated == description.end() || !stated->is_object() || text_of(*stated, "sha256").empty()) {
    return "cell.json does not state the checksum of layers.exr";
  }
  std::error_code error;
  if (!fs::is_regular_file(exr, error)) return "layers.exr is missing";
  try {
    if (sha256_file(exr) == text_of(*stated, "sha256")) return "";
  } catch (const std::runtime_error& failure) {
    return failure.what();
  }
  return "layers.exr is damaged: its checksum is wrong";
}

/// Fills the cell from its cell.json; returns what is wrong.
std::string read_description(Cell& cell, const fs::path& folder, const std::string& expected) {
  std::error_code error;
  if (!fs::exists(folder, error)) return "missing";
  if (!fs::is_regular_file(folder / "cell.json", error)) return "cell.json is missing";
  const json description = parse_limited_json_or_discard(read_text(folder / "cell.json"));
  if (!description.is_object()) return "cell.json is damaged: not JSON";
  if (description.value("format", json()) != json(cell_format)) {
    return fmt::format("cell.json has format {}, this occlab reads {}",
                       description.value("format", json()).dump(), cell_format);
  }
  const auto facts = facts_of(description);
  if (!facts) return "cell.json is damaged: its facts are not pairs of texts";
  cell.facts = *facts;
  if (const std::string* method = find_text(cell.facts, "method")) cell.method = *method;
  if (const std::string* text = find_text(cell.facts, "parameters")) {
    cell.parameters = parse_parameters(*text);
  }
  const std::string key = text_of(description, "key");
  if (!key.starts_with(cell.id) || (!expected.empty() && key != expected)) {
    return "cell.json is of another cell";
  }
  return check_pixels(cell.exr, description);
}

long rays_of(const Cell& cell) {
  const std::string* rays = find_text(cell.parameters, "rays_per_pixel");
  return rays ? std::strtol(rays->c_str(), nullptr, 10) : 0;
}

NamedTexts without_seed(NamedTexts parameters) {
  std::erase_if(parameters, [](const auto& parameter) { return parameter.first == "seed"; });
  return parameters;
}

/// Without a run.json a folder may hold cells of several runs: those that were not made of what the
/// first one was made of are not compared with it.
void mark_strangers(std::vector<Cell>& cells) {
  const auto first = std::ranges::find(cells, "", &Cell::problem);
  for (auto cell = first; cell != cells.end(); ++cell) {
    for (const char* name : {"scene", "view", "resolution", "probe", "probe_settings"}) {
      const std::string* own = find_text(cell->facts, name);
      const std::string* wanted = find_text(first->facts, name);
      if (!cell->problem.empty() || (!own && !wanted) || (own && wanted && *own == *wanted))
        continue;
      cell->problem = fmt::format("of another run: its {} is not that of cell {}", name, first->id);
    }
  }
}

/// The reference's cell, or the number of cells if there is none.
std::size_t find_reference(const std::vector<Cell>& cells, const json& run) {
  if (run.is_object()) {
    if (!run.contains("reference")) return cells.size();
    const std::string id = text_of(run["reference"], "cell");
    return std::size_t(std::ranges::find(cells, id, &Cell::id) - cells.begin());
  }
  const auto best = std::ranges::max_element(cells, {}, rays_of);
  if (best == cells.end() || rays_of(*best) == 0) return cells.size();
  return std::size_t(best - cells.begin());
}

/// What a method approximates; "" of one that is not known any more.
std::string truth_of(const std::string& method) {
  const auto found = std::ranges::find(methods(), method, &MethodInfo::name);
  return found == methods().end() ? "" : found->truth;
}

/// Finds every group's truth among the further references that run.json names.
void find_truths(const std::vector<Cell>& cells, const json& run, std::vector<Group>& groups) {
  if (!run.is_object() || !run.contains("reference") || !run["reference"].is_object()) return;
  for (const json& id : run["reference"].value("others", json::array())) {
    const auto holds = [&](const Group& group) {
      return id.is_string() && cells[group.cells.front()].id == id.get<std::string>();
    };
    const auto truth = std::ranges::find_if(groups, holds);
    if (truth == groups.end()) continue;
    const auto place = std::size_t(truth - groups.begin());
    for (Group& group : groups) {
      if (!group.reference && truth_of(group.method) == truth->method) group.truth = place;
    }
    truth->truth = place;
  }
}

}  // namespace

const std::string* find_text(const NamedTexts& texts, const std::string& name) {
  const auto found = std::ranges::find(texts, name, &NamedTexts::value_type::first);
  return found == texts.end() ? nullptr : &found->second;
}

NamedTexts parse_parameters(const std::string& text) {
  NamedTexts parameters;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos) continue;
    parameters.emplace_back(word.substr(0, equals), word.substr(equals + 1));
  }
  return parameters;
}

Cell inspect_cell(const fs::path& results, const std::string& id, const std::string& expected) {
  const fs::path folder = results / "cells" / id;
  Cell cell;
  cell.id = id;
  cell.exr = folder / "layers.exr";
  cell.problem = read_description(cell, folder, expected);
  return cell;
}

std::vector<Cell> inspect_cells(const fs::path& results, const json& run) {
  struct Listed {
    std::string id, hash, method, parameters;
  };
  std::vector<Listed> listed;
  if (run.is_object()) {
    for (const json& cell : run.value("cells", json::array())) {
      listed.push_back({text_of(cell, "id"), text_of(cell, "hash"), text_of(cell, "method"),
                        text_of(cell, "parameters")});
    }
  } else {
    std::error_code error;
    for (fs::directory_iterator entry(results / "cells", error), end; !error && entry != end;
         entry.increment(error)) {
      const std::string name = entry->path().filename().string();
      if (!name.starts_with(".")) listed.push_back({name, "", "", ""});
    }
    std::ranges::sort(listed, {}, &Listed::id);
  }
  std::vector<Cell> cells(listed.size());
  parallel_for(listed.size(), [&](std::size_t i) {
    cells[i] = inspect_cell(results, listed[i].id, listed[i].hash);
    // A cell that is gone is still called what run.json says it was.
    if (cells[i].method.empty()) cells[i].method = listed[i].method;
    if (cells[i].parameters.empty()) {
      cells[i].parameters = parse_parameters(listed[i].parameters);
    }
  });
  if (!run.is_object()) mark_strangers(cells);
  return cells;
}

std::optional<Layers> read_layers(Cell& cell) {
  if (!cell.problem.empty()) return std::nullopt;
  try {
    return read_exr(cell.exr).layers;
  } catch (const InputError& error) {
    cell.problem = error.what();
    return std::nullopt;
  }
}

std::vector<Group> group_cells(const std::vector<Cell>& cells, const json& run) {
  const std::size_t reference = find_reference(cells, run);
  std::vector<Group> groups;
  if (reference < cells.size()) {
    groups.push_back(
        {cells[reference].method, without_seed(cells[reference].parameters), {reference}, true});
  }
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Cell& cell = cells[i];
    const bool part = reference < cells.size() && cell.method == cells[reference].method;
    if (cell.method.empty() || part) continue;
    const NamedTexts parameters = without_seed(cell.parameters);
    const auto known = std::ranges::find_if(groups, [&](const Group& group) {
      return !group.reference && group.method == cell.method && group.parameters == parameters;
    });
    if (known != groups.end()) {
      known->cells.push_back(i);
    } else {
      groups.push_back({cell.method, parameters, {i}, false});
    }
  }
  find_truths(cells, run, groups);
  return groups;
}

}  // namespace occlab::report
