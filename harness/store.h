#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "harness/files.h"
#include "renderers/scene/image_io.h"

namespace occlab {

/// Everything that determines a cell's pixels, as ordered (name, value) facts: file hashes, view,
/// resolution, method, parameters, expanded shaders, device and driver, code version.
class CellKey {
 public:
  /// A name is given once and is not empty.
  void add(std::string name, std::string value);
  const std::vector<std::pair<std::string, std::string>>& facts() const { return facts_; }

  /// SHA-256 (64 hex digits) of the facts in their order.
  std::string hash() const;
  /// The cell's name: the first 16 digits of hash().
  std::string id() const { return hash().substr(0, 16); }

  bool operator==(const CellKey& other) const { return facts_ == other.facts_; }

 private:
  std::vector<std::pair<std::string, std::string>> facts_;
  mutable std::string hash_;  ///< "" while it was not asked for; a key belongs to one thread
};

struct StoredCell {
  std::string id;
  std::filesystem::path folder;
  Layers layers;
  Metadata metadata;     ///< as given to write(), keys starting with "occlab:" only
  nlohmann::json extra;  ///< as given to write()
};

struct ReadCell {
  std::optional<StoredCell> cell;  ///< empty: there is none, or it was damaged
  std::string warning;             ///< not empty: what was damaged and where it was moved
};

/// The contents of a cell's cell.json where CellStore::has() would hold for the key it has.
std::optional<nlohmann::json> describe_intact_cell(const std::filesystem::path& cell_folder);

/// Finished cells under FOLDER/cells/ID/{layers.exr, cell.json}. A cell appears whole, by rename,
/// and is never changed again; several processes and machines may share the folder. A damaged cell
/// is moved to FOLDER/damaged/. All functions throw DeviceError, naming the path and the system's
/// reason, when the folder cannot be used; nothing is half-written then.
class CellStore {
 public:
  /// Creates the folder where needed and removes the left-overs of killed writers of this machine
  /// that are at least `left_over_age` old.
  explicit CellStore(std::filesystem::path folder,
                     std::chrono::seconds left_over_age = std::chrono::seconds(60));

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path cell_folder(const CellKey& key) const;

  /// Whether there is a cell with an intact cell.json and a layers.exr of the stated size; read()
  /// alone verifies the pixels. Throws InputError when the cell that is there has other facts: a
  /// collision of the short hash or an edited file.
  bool has(const CellKey& key) const;

  /// `extra` holds what was measured while rendering (times, warnings). Where another process
  /// finished the same cell first, that one is kept. Returns the cell's folder.
  std::filesystem::path write(const CellKey& key, const Layers& layers, const Metadata& metadata,
                              const nlohmann::json& extra = nlohmann::json::object());

  /// Verifies the checksums: of pixels that this process has written or verified before only where
  /// the file is another one since. Throws InputError as has() does.
  ReadCell read(const CellKey& key);

 private:
  /// What tells a file from one that came in its place or was written to.
  struct FileState {
    std::uint64_t inode = 0;
    std::int64_t size = 0;
    std::int64_t seconds = 0;
    std::int64_t nanoseconds = 0;
    bool operator==(const FileState&) const = default;
  };
  static std::optional<FileState> state_of(const std::filesystem::path& path);
  bool verified(const std::filesystem::path& exr);
  void remember_verified(const std::filesystem::path& exr, const std::optional<FileState>& state);

  std::filesystem::path folder_;
  std::mutex mutex_;  ///< of verified_: cells are read on several threads
  std::map<std::filesystem::path, FileState> verified_;
};

}  // namespace occlab
