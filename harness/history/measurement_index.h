#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "harness/history/sqlite.h"
#include "harness/tables.h"

namespace occlab::history {

/// RESULTS/measurements.sqlite, an index over RESULTS/measurements.csv: the same rows, every text
/// stored once. It can always be made again from the file, and is where that is not the one it was
/// made of, by its size, its inode and its times of change.
class MeasurementIndex {
 public:
  /// Makes or renews the index where needed, a block of rows at a time, and says so on stderr.
  /// Throws InputError where measurements.csv is missing or not one, DeviceError where the index
  /// cannot be written.
  explicit MeasurementIndex(const std::filesystem::path& results, bool rebuild = false);

  /// A column and the text it is to have. Names are those of measurements.csv; `parameter.` may be
  /// left out.
  using Condition = std::pair<std::string, std::string>;

  /// The rows that meet all conditions, in the file's order, at most `limit`; facts that are the
  /// same in all of them are a note instead of a column. Throws InputError, with what is accepted,
  /// for a column there is none of and for a value that no row has.
  Table query(const std::vector<Condition>& conditions, std::size_t limit) const;

  /// Of the whole file.
  std::int64_t rows() const;

 private:
  std::string column_of(const std::string& name) const;
  std::int64_t text_id(const Condition& condition, const std::string& column) const;

  std::filesystem::path csv_;
  Sqlite database_;
  std::vector<std::string> columns_;  ///< the file's that hold texts
};

}  // namespace occlab::history
