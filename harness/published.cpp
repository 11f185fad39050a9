#include "harness/published.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "harness/csv.h"
#include "harness/files.h"
#include "renderers/scene/data_root.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

// Files of times and files of frame rates.
const std::vector<std::string> time_columns = {"source",  "method", "width",   "height", "device",
                                               "samples", "steps",  "time_ms", "origin", "remark"};
const std::vector<std::string> rate_columns = {"source",         "method",  "width", "height",
                                               "device",         "samples", "steps", "fps",
                                               "slower_percent", "origin",  "remark"};

/// One row of a file, its fields by the names of their columns.
class Row {
 public:
  Row(const fs::path& path, const std::vector<std::string>& columns, const CsvRecord& record)
      : path_(path), columns_(columns), record_(record) {}

  const std::string& field(const std::string& column) const {
    const auto place = std::ranges::find(columns_, column);
    return record_.fields[std::size_t(place - columns_.begin())];
  }
  std::string at(const std::string& column) const {
    return fmt::format("{}:{}: {}", path_.string(), record_.line, column);
  }
  [[noreturn]] void fail(const std::string& column, const std::string& accepted) const {
    throw InputError(
        fmt::format("{}: found {}; accepted is {}", at(column), field(column), accepted));
  }
  const std::string& text(const std::string& column) const {
    if (field(column).empty()) throw InputError(at(column) + ": empty; a text is required");
    return field(column);
  }
  long whole(const std::string& column) const {
    const double value = parse_number(field(column), at(column));
    if (!(value >= 1 && value <= 1e6) || value != std::floor(value)) {
      fail(column, "an integer in [1, 1000000]");
    }
    return long(value);
  }
  double positive(const std::string& column) const {
    const double value = parse_number(field(column), at(column));
    if (!(value > 0) || std::isinf(value)) fail(column, "a positive number");
    return value;
  }
  std::optional<double> percent(const std::string& column) const {
    if (field(column).empty()) return std::nullopt;
    const double value = parse_number(field(column), at(column));
    if (!(std::abs(value) < 100)) fail(column, "a percentage between -100 and 100");
    return value;
  }

 private:
  const fs::path& path_;
  const std::vector<std::string>& columns_;
  const CsvRecord& record_;
};

PublishedTime read_row(const Row& row, bool frame_rates) {
  PublishedTime time;
  time.method = row.text("method");
  time.width = int(row.whole("width"));
  time.height = int(row.whole("height"));
  time.device = row.text("device");
  time.samples = row.whole("samples");
  time.steps = row.whole("steps");
  time.time_ms = frame_rates ? 1000.0 / row.positive("fps") : row.positive("time_ms");
  if (frame_rates) time.slower_percent = row.percent("slower_percent");
  time.origin = row.text("origin");
  time.remark = row.field("remark");
  return time;
}

bool same_place(const PublishedTime& a, const PublishedTime& b) {
  return a.method == b.method && a.samples == b.samples && a.steps == b.steps &&
         a.width == b.width && a.height == b.height && a.origin == b.origin;
}

}  // namespace

fs::path published_path(const std::string& name) {
  return data_root() / "results" / "published" / (name + ".csv");
}

PublishedTimes read_published_times(const fs::path& path) {
  const std::vector<CsvRecord> records = parse_csv(read_text(path), path.string());
  PublishedTimes result;
  result.frame_rates = !records.empty() && records.front().fields == rate_columns;
  const std::vector<std::string>& columns = result.frame_rates ? rate_columns : time_columns;
  if (records.empty() || records.front().fields != columns) {
    throw InputError(fmt::format("{}:1: the columns must be {} or {}", path.string(),
                                 fmt::join(time_columns, ","), fmt::join(rate_columns, ",")));
  }
  for (std::size_t i = 1; i < records.size(); ++i) {
    const Row row(path, columns, records[i]);
    PublishedTime time = read_row(row, result.frame_rates);
    if (i > 1 && row.text("source") != result.source) {
      throw InputError(row.at("source") + ": one file holds one source");
    }
    result.source = row.text("source");
    for (const PublishedTime& other : result.times) {
      if (same_place(time, other)) {
        throw InputError(
            fmt::format("{}:{}: the time of '{}' for {} samples and {} steps at {}x{} "
                        "in '{}' is given twice",
                        path.string(), records[i].line, time.method, time.samples, time.steps,
                        time.width, time.height, time.origin));
      }
    }
    result.times.push_back(std::move(time));
  }
  if (result.times.empty()) throw InputError(fmt::format("{}: no rows", path.string()));
  return result;
}

}  // namespace occlab
