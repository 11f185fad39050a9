#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "harness/history/sqlite.h"

namespace occlab::history {

/// "occl" in ASCII: what PRAGMA application_id says of our files.
inline constexpr std::int64_t application_id = 0x6f63636c;

/// The SQL that takes a database from version i to i + 1 (PRAGMA user_version). A published step is
/// never changed: databases that went through it are out there. FORMAT.md says what the tables
/// mean.
std::span<const std::string_view> migrations();
inline std::int64_t newest_version() { return std::int64_t(migrations().size()); }

/// Opens a history and brings it to the newest version, in one transaction. Throws InputError for a
/// file that is not a history (text, a damaged file, the database of another program) and for one
/// of a newer version, DeviceError where an old one would have to be changed and may not be
/// written.
Sqlite open_history(const std::filesystem::path& path, bool create);

}  // namespace occlab::history
