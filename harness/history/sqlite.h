#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace occlab::history {

/// An open SQLite file, which may come from anywhere: views and triggers in it are not run, and
/// values of over 256 MB are an error. Every failure throws with the file's path: InputError where
/// the file is no database, damaged or not of this shape, DeviceError where the disk, its rights or
/// another process stand in the way.
class Sqlite {
 public:
  /// Opens a file, or makes an empty one where `create` is set; a file that may not be written is
  /// opened for reading. Waits up to 30 s for other processes. Throws InputError where there is
  /// none.
  Sqlite(std::filesystem::path path, bool create);

  const std::filesystem::path& path() const { return path_; }
  bool read_only() const;

  /// One or more statements without results.
  void execute(const std::string& sql) const;
  /// The first column of the only row.
  std::int64_t integer(const std::string& sql) const;
  std::int64_t last_row() const;

  sqlite3* get() const { return database_.get(); }
  /// Throws what `code` means.
  [[noreturn]] void fail(int code) const;

 private:
  std::filesystem::path path_;
  struct Close {
    void operator()(sqlite3* database) const;
  };
  std::unique_ptr<sqlite3, Close> database_;
};

/// A prepared statement: bind() what is asked for in order, then step() through the rows.
class Statement {
 public:
  Statement(const Sqlite& database, const std::string& sql);

  Statement& bind(std::int64_t value);
  Statement& bind(std::string_view text);
  Statement& bind(const std::optional<double>& value);  ///< none: NULL
  Statement& bind(std::span<const std::uint8_t> bytes);

  /// Whether there is a (further) row.
  bool step();
  /// For statements without rows; may be bound and run again.
  void run();
  /// Starts over with other values.
  void reset();

  std::int64_t integer(int column) const;
  std::string text(int column) const;
  std::optional<double> number(int column) const;
  /// Valid until the next step.
  std::span<const std::uint8_t> bytes(int column) const;

 private:
  void check(int code) const;
  const Sqlite& database_;
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  int bound_ = 0;
};

/// All or nothing: what is not committed is as if it had never been. Takes the write lock at once,
/// so that two processes take turns instead of failing halfway.
class Transaction {
 public:
  explicit Transaction(const Sqlite& database);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  const Sqlite& database_;
  bool open_ = true;
};

}  // namespace occlab::history
