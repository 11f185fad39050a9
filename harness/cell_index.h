#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "harness/store.h"

namespace occlab {

/// What cell.json says of a finished cell.
struct CellDescription {
  std::string id;
  std::vector<std::pair<std::string, std::string>> facts;  ///< CellKey::facts()
  nlohmann::json extra;                                    ///< as given to CellStore::write()

  /// nullptr if there is no such fact.
  const std::string* fact(const std::string& name) const;
};

/// The finished cells of FOLDER/cells by their ids; those whose cell.json or whose size of
/// layers.exr is not as it was written are left out. Reads no pixels, writes nothing, and takes a
/// folder that is not there for an empty one. Throws DeviceError where it cannot be listed.
std::map<std::string, CellDescription> index_cells(const std::filesystem::path& folder);

/// A fact in which two cells differ; "" where one has none.
struct FactDifference {
  std::string name;  ///< "parameters.samples" where the fact is a list of NAME=VALUE
  std::string stored;
  std::string wanted;
};
std::vector<FactDifference> differences(const CellDescription& stored, const CellKey& wanted);

/// The cell with the fewest differences, of equals the first; nullptr if there are no cells.
const CellDescription* nearest_cell(const std::map<std::string, CellDescription>& cells,
                                    const CellKey& wanted);

}  // namespace occlab
