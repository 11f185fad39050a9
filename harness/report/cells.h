#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "renderers/scene/image_io.h"

namespace occlab::report {

using NamedTexts = std::vector<std::pair<std::string, std::string>>;

/// The value of a name, nullptr if it is not there.
const std::string* find_text(const NamedTexts& texts, const std::string& name);

/// A cell of a results folder as a reader sees it, who repairs and moves nothing (unlike
/// CellStore, which is for those who can render it again).
struct Cell {
  std::string id;
  std::filesystem::path exr;
  std::string method;     ///< empty: an error budget
  NamedTexts parameters;  ///< with `seed`
  NamedTexts facts;       ///< of cell.json
  /// Empty: cell.json is whole and layers.exr has its checksum. Else "missing", or what is wrong.
  std::string problem;
};

/// "samples=8 seed=0" as names and values.
NamedTexts parse_parameters(const std::string& text);

/// Checks RESULTS/cells/ID. `expected`: the full hash that run.json gives, "" if none is known.
Cell inspect_cell(const std::filesystem::path& results, const std::string& id,
                  const std::string& expected);

/// The cells that run.json lists, in its order; without a run.json (null) all there are, by name.
std::vector<Cell> inspect_cells(const std::filesystem::path& results, const nlohmann::json& run);

/// The layers, or nothing where the cell has a problem; what is found on reading becomes one.
std::optional<Layers> read_layers(Cell& cell);

/// Cells that differ in their seed only.
struct Group {
  std::string method;
  NamedTexts parameters;           ///< without `seed`
  std::vector<std::size_t> cells;  ///< indices, in order of appearance
  bool reference = false;
  /// Index of the group that holds the reference that this one is compared with: the first, or of
  /// several references that of the method's truth, which is itself compared with itself.
  std::size_t truth = 0;
};

/// Test cells by group, in order of appearance, after the reference, where there is one: the cell
/// that run.json calls so, else the one with the most rays a pixel. Parts of a reference that was
/// traced in several are left out.
std::vector<Group> group_cells(const std::vector<Cell>& cells, const nlohmann::json& run);

}  // namespace occlab::report
