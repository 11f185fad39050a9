#include "harness/cell_index.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "renderers/scene/error.h"
#include "renderers/scene/parallel.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;
using Facts = std::vector<std::pair<std::string, std::string>>;

/// An empty id where the cell is not as it was written.
CellDescription describe_cell(const fs::path& folder) {
  try {
    const std::optional<json> stored = describe_intact_cell(folder);
    if (!stored) return {};
    return {folder.filename().string(), stored->at("facts").get<Facts>(), stored->at("extra")};
  } catch (const json::exception&) {
    return {};  // facts that are no pairs of texts
  }
}

/// "samples=4 steps=2" as names and values; nothing for any other text.
Facts named_values(const std::string& text) {
  Facts values;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const std::size_t equals = word.find('=');
    if (equals == 0 || equals == std::string::npos) return {};
    values.emplace_back(word.substr(0, equals), word.substr(equals + 1));
  }
  return values;
}

const std::string* find(const Facts& facts, const std::string& name) {
  const auto fact = std::ranges::find(facts, name, &Facts::value_type::first);
  return fact == facts.end() ? nullptr : &fact->second;
}

/// `prefix` goes before the names.
void compare(const Facts& stored, const Facts& wanted, const std::string& prefix,
             std::vector<FactDifference>& found) {
  for (const auto& [name, value] : wanted) {
    const std::string* const old = find(stored, name);
    if (old && *old == value) continue;
    const Facts old_values = old ? named_values(*old) : Facts();
    const Facts new_values = named_values(value);
    if (!old_values.empty() && !new_values.empty()) {
      compare(old_values, new_values, prefix + name + ".", found);
    } else {
      found.push_back({prefix + name, old ? *old : "", value});
    }
  }
  for (const auto& [name, value] : stored) {
    if (!find(wanted, name)) found.push_back({prefix + name, value, ""});
  }
}

}  // namespace

const std::string* CellDescription::fact(const std::string& name) const {
  return find(facts, name);
}

std::map<std::string, CellDescription> index_cells(const fs::path& folder) {
  std::vector<fs::path> paths;
  std::error_code error;
  if (!fs::exists(folder / "cells", error)) return {};
  for (fs::directory_iterator entry(folder / "cells", error), end; !error && entry != end;
       entry.increment(error)) {
    if (!entry->path().filename().string().starts_with(".")) paths.push_back(entry->path());
  }
  if (error) {
    throw DeviceError(
        fmt::format("{}: cannot be listed: {}", (folder / "cells").string(), error.message()));
  }
  std::vector<CellDescription> cells(paths.size());
  parallel_for(paths.size(), [&](std::size_t i) { cells[i] = describe_cell(paths[i]); });
  std::map<std::string, CellDescription> index;
  for (CellDescription& cell : cells) {
    const std::string id = cell.id;
    if (!id.empty()) index.emplace(id, std::move(cell));
  }
  return index;
}

std::vector<FactDifference> differences(const CellDescription& stored, const CellKey& wanted) {
  std::vector<FactDifference> found;
  compare(stored.facts, wanted.facts(), "", found);
  return found;
}

const CellDescription* nearest_cell(const std::map<std::string, CellDescription>& cells,
                                    const CellKey& wanted) {
  const CellDescription* nearest = nullptr;
  std::size_t fewest = 0;
  for (const auto& [id, cell] : cells) {
    const std::size_t count = differences(cell, wanted).size();
    if (nearest && count >= fewest) continue;
    nearest = &cell;
    fewest = count;
  }
  return nearest;
}

}  // namespace occlab
