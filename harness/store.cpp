#include "harness/store.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <ctime>

#include "renderers/scene/error.h"
#include "renderers/scene/limited_json.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::json;

constexpr std::string_view temporary_prefix = ".tmp-";

std::string host_name() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return "localhost";
  return name.data();
}

/// `.tmp-HOST-PID-COUNTER`: process numbers mean something on their own machine only, and the
/// folder may be shared by several.
std::string temporary_name() {
  static std::atomic<unsigned> counter = 0;
  return fmt::format("{}{}-{}-{}", temporary_prefix, host_name(), ::getpid(), counter++);
}

/// The process that made a temporary of this machine, 0 for any other name.
pid_t writer_of(const std::string& name) {
  const std::string ours = fmt::format("{}{}-", temporary_prefix, host_name());
  if (!name.starts_with(ours)) return 0;
  pid_t process = 0;
  const char* const end = name.data() + name.size();
  const auto [rest, error] = std::from_chars(name.data() + ours.size(), end, process);
  return error == std::errc() && rest != end && *rest == '-' ? process : 0;
}

void remove_left_overs(const fs::path& cells, std::chrono::seconds minimum_age) {
  std::error_code error;
  for (fs::directory_iterator entry(cells, error), end; !error && entry != end;
       entry.increment(error)) {
    const pid_t writer = writer_of(entry->path().filename().string());
    if (writer <= 0) continue;
    const bool dead = ::kill(writer, 0) != 0 && errno == ESRCH;
    struct stat status {};
    if (!dead || ::lstat(entry->path().c_str(), &status) != 0) continue;
    if (std::time(nullptr) - status.st_mtime < minimum_age.count()) continue;
    std::error_code ignored;  // another process may be removing the same left-over
    fs::remove_all(entry->path(), ignored);
  }
  if (error) {
    throw DeviceError(fmt::format("{}: cannot be listed: {}", cells.string(), error.message()));
  }
}

/// What stands in a cell's place.
struct Inspection {
  enum class State { missing, damaged, intact } state = State::missing;
  std::string reason;  ///< damaged
  Json description;    ///< intact: the contents of cell.json
};

Json facts_to_json(const CellKey& key) {
  Json facts = Json::array();
  for (const auto& [name, value] : key.facts()) facts.push_back(Json::array({name, value}));
  return facts;
}

/// "fact 'steps' is '2' there and '4' here": the first difference between two lists of facts.
std::string first_difference(const Json& stored, const Json& wanted) {
  for (std::size_t i = 0; i < std::max(stored.size(), wanted.size()); ++i) {
    if (i >= stored.size()) return fmt::format("fact {} is not there", wanted[i].dump());
    if (i >= wanted.size()) return fmt::format("fact {} is not wanted", stored[i].dump());
    if (stored[i] != wanted[i]) {
      return fmt::format("it holds {} where {} is wanted", stored[i].dump(), wanted[i].dump());
    }
  }
  return "its key is another one";
}

/// Of all that cell.json says but this checksum itself.
std::string checksum(Json description) {
  description.erase("sha256");
  return sha256_text(description.dump());
}

/// Whatever its key is. Compares the size of layers.exr; does not read the pixels.
Inspection inspect(const fs::path& folder) {
  using State = Inspection::State;
  std::error_code error;
  const fs::file_status status = fs::symlink_status(folder, error);
  if (status.type() == fs::file_type::not_found) return {};
  if (error) {
    throw DeviceError(fmt::format("{}: cannot be read: {}", folder.string(), error.message()));
  }
  const auto damaged = [](std::string reason) {
    return Inspection{State::damaged, std::move(reason), {}};
  };
  const fs::path description_path = folder / "cell.json";
  if (!fs::is_regular_file(description_path, error)) return damaged("cell.json is missing");
  std::string text;
  try {
    text = read_text(description_path);
  } catch (const InputError&) {
    // Another process may just have moved the cell aside.
    if (!fs::exists(folder, error)) return {};
    throw;
  }
  Json description = parse_limited_json_or_discard(text);
  if (description.is_discarded() || !description.is_object()) {
    return damaged("cell.json is not JSON");
  }
  const auto stored_facts = description.find("facts");
  const auto exr = description.find("layers.exr");
  const auto has = [&](const char* name, Json::value_t type) {
    return exr->find(name) != exr->end() && (*exr)[name].type() == type;
  };
  if (stored_facts == description.end() || !stored_facts->is_array() || exr == description.end() ||
      !exr->is_object() || !has("bytes", Json::value_t::number_unsigned) ||
      !has("sha256", Json::value_t::string) || !description.contains("extra") ||
      !description.contains("metadata") || !description["metadata"].is_object() ||
      !description.contains("sha256")) {
    return damaged("cell.json is incomplete");
  }
  if (description["sha256"] != checksum(description)) {
    return damaged("the checksum of cell.json is wrong");
  }
  const auto size = fs::file_size(folder / "layers.exr", error);
  if (error) return damaged("layers.exr is missing");
  if (size != (*exr)["bytes"].get<std::uintmax_t>()) {
    return damaged(fmt::format("layers.exr has {} bytes instead of {}", size,
                               (*exr)["bytes"].get<std::uintmax_t>()));
  }
  return {State::intact, {}, std::move(description)};
}

/// As inspect(), and throws InputError if the cell is another one's.
Inspection inspect(const fs::path& folder, const CellKey& key) {
  Inspection found = inspect(folder);
  if (found.state != Inspection::State::intact) return found;
  if (const Json wanted = facts_to_json(key); found.description["facts"] != wanted) {
    throw InputError(fmt::format(
        "{}: this cell belongs to another key: {}; it was edited, or two keys share their first 16 "
        "digits. Remove the cell's folder to render it again",
        (folder / "cell.json").string(), first_difference(found.description["facts"], wanted)));
  }
  return found;
}

/// Moves a damaged cell out of the way and says so. Another process may have done it already.
std::string move_aside(const fs::path& store, const fs::path& cell, const std::string& reason) {
  create_folder(store / "damaged");
  const fs::path target =
      store / "damaged" / (cell.filename().string() + temporary_name().substr(4));
  if (::rename(cell.c_str(), target.c_str()) != 0 && errno != ENOENT) {
    throw DeviceError(fmt::format("{}: damaged ({}) and cannot be moved aside: {}", cell.string(),
                                  reason, std::strerror(errno)));
  }
  return fmt::format("{}: damaged: {}; moved to {} and taken as missing", cell.string(), reason,
                     target.string());
}

/// Makes the finished temporary the cell, unless another process was first.
void publish(const fs::path& store, const fs::path& temporary, const fs::path& cell,
             const CellKey& key) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    if (::rename(temporary.c_str(), cell.c_str()) == 0) return;
    if (errno != ENOTEMPTY && errno != EEXIST && errno != ENOTDIR) break;
    // Only a damaged one makes room; an intact one is kept.
    const Inspection theirs = inspect(cell, key);
    if (theirs.state == Inspection::State::intact) {
      fs::remove_all(temporary);
      return;
    }
    if (theirs.state == Inspection::State::damaged) move_aside(store, cell, theirs.reason);
    errno = EEXIST;
  }
  throw DeviceError(
      fmt::format("{}: cannot be put in its place: {}", cell.string(), std::strerror(errno)));
}

}  // namespace

std::optional<Json> describe_intact_cell(const fs::path& folder) {
  Inspection found = inspect(folder);
  if (found.state != Inspection::State::intact) return std::nullopt;
  return std::move(found.description);
}

void CellKey::add(std::string name, std::string value) {
  assert(!name.empty());
  assert(std::ranges::none_of(facts_, [&](const auto& fact) { return fact.first == name; }));
  facts_.emplace_back(std::move(name), std::move(value));
  hash_.clear();
}

// JSON as the text that is hashed: names and values cannot run into each other.
std::string CellKey::hash() const {
  try {
    if (hash_.empty()) hash_ = sha256_text(facts_to_json(*this).dump());
    return hash_;
  } catch (const Json::exception& error) {
    throw InputError(fmt::format("a fact of a cell is not UTF-8 text: {}", error.what()));
  }
}

CellStore::CellStore(fs::path folder, std::chrono::seconds left_over_age)
    : folder_(std::move(folder)) {
  const fs::path cells = folder_ / "cells";
  create_folder(cells);
  if (::access(cells.c_str(), W_OK | X_OK) != 0) {
    throw DeviceError(
        fmt::format("{}: cannot be written: {}", cells.string(), std::strerror(errno)));
  }
  remove_left_overs(cells, left_over_age);
}

fs::path CellStore::cell_folder(const CellKey& key) const { return folder_ / "cells" / key.id(); }

bool CellStore::has(const CellKey& key) const {
  return inspect(cell_folder(key), key).state == Inspection::State::intact;
}

fs::path CellStore::write(const CellKey& key, const Layers& layers, const Metadata& metadata,
                          const Json& extra) {
  const fs::path cell = cell_folder(key);
  const fs::path temporary = folder_ / "cells" / temporary_name();
  try {
    create_folder(temporary);
    const fs::path exr = temporary / "layers.exr";
    write_exr(exr, layers, metadata);
    sync_path(exr);
    const std::optional<FileState> state = state_of(exr);
    Json description;
    description["format"] = 1;
    description["key"] = key.hash();
    description["facts"] = facts_to_json(key);
    description["layers.exr"] = {{"bytes", fs::file_size(exr)}, {"sha256", sha256_file(exr)}};
    description["metadata"] = metadata;
    description["extra"] = extra;
    description["sha256"] = checksum(description);
    write_text_atomically(temporary / "cell.json", description.dump(2) + "\n");
    publish(folder_, temporary, cell, key);
    remember_verified(cell / "layers.exr", state);  // not one that another process has put there
    sync_path(folder_ / "cells");
  } catch (const fs::filesystem_error& error) {
    std::error_code ignored;
    fs::remove_all(temporary, ignored);
    throw DeviceError(
        fmt::format("{}: cannot be written: {}", cell.string(), error.code().message()));
  } catch (const Json::exception& error) {
    std::error_code ignored;
    fs::remove_all(temporary, ignored);
    throw InputError(fmt::format("{}: a fact is not UTF-8 text: {}", cell.string(), error.what()));
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(temporary, ignored);
    throw;
  }
  return cell;
}

std::optional<CellStore::FileState> CellStore::state_of(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return FileState{.inode = status.st_ino,
                   .size = status.st_size,
                   .seconds = status.st_mtim.tv_sec,
                   .nanoseconds = status.st_mtim.tv_nsec};
}

bool CellStore::verified(const fs::path& exr) {
  const std::optional<FileState> state = state_of(exr);
  const std::lock_guard lock(mutex_);
  const auto found = verified_.find(exr);
  return state && found != verified_.end() && found->second == *state;
}

/// `state`: that of before its contents were read.
void CellStore::remember_verified(const fs::path& exr, const std::optional<FileState>& state) {
  if (!state) return;
  const std::lock_guard lock(mutex_);
  verified_[exr] = *state;
}

ReadCell CellStore::read(const CellKey& key) {
  const fs::path cell = cell_folder(key);
  Inspection found = inspect(cell, key);
  if (found.state == Inspection::State::missing) return {};
  const auto damaged = [&](const std::string& reason) {
    return ReadCell{std::nullopt, move_aside(folder_, cell, reason)};
  };
  if (found.state == Inspection::State::damaged) return damaged(found.reason);
  const Json& description = found.description;
  const fs::path exr = cell / "layers.exr";
  if (!verified(exr)) {
    const std::optional<FileState> state = state_of(exr);
    if (sha256_file(exr) != description["layers.exr"]["sha256"]) {
      return damaged("the checksum of layers.exr is wrong");
    }
    remember_verified(exr, state);
  }
  try {
    ExrFile file = read_exr(cell / "layers.exr");
    return {StoredCell{key.id(), cell, std::move(file.layers), std::move(file.metadata),
                       description["extra"]},
            {}};
  } catch (const InputError& error) {
    return damaged(error.what());
  }
}

}  // namespace occlab
