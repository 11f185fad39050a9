#include "harness/history/sqlite.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <utility>

#include "renderers/scene/error.h"

namespace occlab::history {
namespace fs = std::filesystem;
namespace {

constexpr int patience_ms = 30'000;
constexpr int longest_value = 256 << 20;  // bytes of a text or picture

bool is_the_files_fault(int code) {
  switch (code & 0xff) {
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
    case SQLITE_FORMAT:
    case SQLITE_ERROR:  // a table or column that is not there
      return true;
    default:
      return false;
  }
}

/// A file may come from anywhere, and its schema is program text: none of it is run. A history has
/// no views and no triggers.
void distrust(sqlite3* database) {
  for (const auto& [option, value] :
       {std::pair(SQLITE_DBCONFIG_DEFENSIVE, 1), std::pair(SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0),
        std::pair(SQLITE_DBCONFIG_ENABLE_VIEW, 0), std::pair(SQLITE_DBCONFIG_ENABLE_TRIGGER, 0)}) {
    sqlite3_db_config(database, option, value, nullptr);
  }
  sqlite3_limit(database, SQLITE_LIMIT_LENGTH, longest_value);
}

}  // namespace

Sqlite::Sqlite(fs::path path, bool create) : path_(std::move(path)) {
  std::error_code error;
  if (!create && !fs::exists(path_, error)) {
    throw InputError(
        fmt::format("{}: there is no such history; 'occlab history add RESULTS --db {}' begins one",
                    path_.string(), path_.string()));
  }
  if (fs::is_directory(path_, error)) {
    throw InputError(fmt::format("{}: is a folder; a file is expected", path_.string()));
  }
  if (fs::exists(path_, error) && !fs::is_regular_file(path_, error)) {
    throw InputError(fmt::format("{}: is no regular file; one is expected", path_.string()));
  }
  sqlite3* opened = nullptr;
  const int flags = SQLITE_OPEN_READWRITE | (create ? SQLITE_OPEN_CREATE : 0);
  const int code = sqlite3_open_v2(path_.c_str(), &opened, flags, nullptr);
  database_.reset(opened);
  if (code != SQLITE_OK) fail(code);
  sqlite3_busy_timeout(opened, patience_ms);
  sqlite3_extended_result_codes(opened, 1);
  distrust(opened);
  execute("PRAGMA foreign_keys = ON; PRAGMA cell_size_check = ON");
}

void Sqlite::Close::operator()(sqlite3* database) const { sqlite3_close_v2(database); }

bool Sqlite::read_only() const { return sqlite3_db_readonly(database_.get(), "main") == 1; }

void Sqlite::execute(const std::string& sql) const {
  const int code = sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail(code);
}

std::int64_t Sqlite::integer(const std::string& sql) const {
  Statement statement(*this, sql);
  if (!statement.step()) fail(SQLITE_CORRUPT);
  return statement.integer(0);
}

std::int64_t Sqlite::last_row() const { return sqlite3_last_insert_rowid(database_.get()); }

void Sqlite::fail(int code) const {
  const char* const said = database_ ? sqlite3_errmsg(database_.get()) : sqlite3_errstr(code);
  switch (code & 0xff) {
    case SQLITE_NOTADB:
      throw InputError(
          fmt::format("{}: is not an SQLite database; a history made by 'occlab "
                      "history add' is expected",
                      path_.string()));
    case SQLITE_CORRUPT:
      throw InputError(
          fmt::format("{}: is damaged ({}); restore a copy, or make it again with 'occlab history "
                      "add' from the results",
                      path_.string(), said));
    case SQLITE_READONLY:
      throw DeviceError(fmt::format("{}: cannot be written: it is read-only", path_.string()));
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw DeviceError(fmt::format("{}: another process has held it for {} s", path_.string(),
                                    patience_ms / 1000));
    case SQLITE_CANTOPEN:
      throw DeviceError(fmt::format("{}: cannot be opened: {}", path_.string(), said));
    default:
      break;
  }
  const std::string message = fmt::format("{}: {}", path_.string(), said);
  if (is_the_files_fault(code)) throw InputError(message);
  throw DeviceError(message);
}

void Statement::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Statement::Statement(const Sqlite& database, const std::string& sql) : database_(database) {
  sqlite3_stmt* prepared = nullptr;
  check(sqlite3_prepare_v2(database.get(), sql.c_str(), int(sql.size()), &prepared, nullptr));
  statement_.reset(prepared);
}

void Statement::check(int code) const {
  if (code != SQLITE_OK) database_.fail(code);
}

Statement& Statement::bind(std::int64_t value) {
  check(sqlite3_bind_int64(statement_.get(), ++bound_, value));
  return *this;
}

Statement& Statement::bind(std::string_view text) {
  check(sqlite3_bind_text64(statement_.get(), ++bound_, text.data(), text.size(), SQLITE_TRANSIENT,
                            SQLITE_UTF8));
  return *this;
}

Statement& Statement::bind(const std::optional<double>& value) {
  ++bound_;
  check(value ? sqlite3_bind_double(statement_.get(), bound_, *value)
              : sqlite3_bind_null(statement_.get(), bound_));
  return *this;
}

Statement& Statement::bind(std::span<const std::uint8_t> bytes) {
  check(sqlite3_bind_blob64(statement_.get(), ++bound_, bytes.data(), bytes.size(),
                            SQLITE_TRANSIENT));
  return *this;
}

bool Statement::step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) database_.fail(code);
  return false;
}

void Statement::run() {
  step();
  reset();
}

void Statement::reset() {
  sqlite3_reset(statement_.get());
  bound_ = 0;
}

std::int64_t Statement::integer(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

std::string Statement::text(int column) const {
  const unsigned char* const text = sqlite3_column_text(statement_.get(), column);
  const int size = sqlite3_column_bytes(statement_.get(), column);
  return text ? std::string(reinterpret_cast<const char*>(text), std::size_t(size)) : std::string();
}

std::optional<double> Statement::number(int column) const {
  if (sqlite3_column_type(statement_.get(), column) == SQLITE_NULL) return std::nullopt;
  return sqlite3_column_double(statement_.get(), column);
}

std::span<const std::uint8_t> Statement::bytes(int column) const {
  const void* const bytes = sqlite3_column_blob(statement_.get(), column);
  const int size = sqlite3_column_bytes(statement_.get(), column);
  return {static_cast<const std::uint8_t*>(bytes), std::size_t(size)};
}

Transaction::Transaction(const Sqlite& database) : database_(database) {
  if (database.read_only()) database.fail(SQLITE_READONLY);
  database.execute("BEGIN IMMEDIATE");
}

Transaction::~Transaction() {
  if (open_) sqlite3_exec(database_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::commit() {
  database_.execute("COMMIT");
  open_ = false;
}

}  // namespace occlab::history
