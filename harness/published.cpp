#include "harness/published.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "harness/csv.h"
#include "harness/files.h"
#include "renderers/scene/data_root.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

const std::vector<std::string> columns = {"source",  "method", "width",   "height", "device",
                                          "samples", "steps",  "time_ms", "origin", "remark"};

}  // namespace

fs::path published_path(const std::string& name) {
  return data_root() / "results" / "published" / (name + ".csv");
}

PublishedTimes read_published_times(const fs::path& path) {
  const std::vector<CsvRecord> records = parse_csv(read_text(path), path.string());
  if (records.empty() || records.front().fields != columns) {
    throw InputError(
        fmt::format("{}:1: the columns must be {}", path.string(), fmt::join(columns, ",")));
  }
  PublishedTimes result;
  for (std::size_t i = 1; i < records.size(); ++i) {
    const CsvRecord& record = records[i];
    const auto at = [&](std::size_t column) {
      return fmt::format("{}:{}: {}", path.string(), record.line, columns[column]);
    };
    const auto text = [&](std::size_t column) {
      if (record.fields[column].empty()) {
        throw InputError(at(column) + ": empty; a text is required");
      }
      return record.fields[column];
    };
    const auto whole = [&](std::size_t column) {
      const double value = parse_number(record.fields[column], at(column));
      if (!(value >= 1 && value <= 1e6) || value != std::floor(value)) {
        throw InputError(fmt::format("{}: found {}; accepted is an integer in [1, 1000000]",
                                     at(column), record.fields[column]));
      }
      return long(value);
    };
    PublishedTime time;
    time.method = text(1);
    time.width = int(whole(2));
    time.height = int(whole(3));
    time.device = text(4);
    time.samples = whole(5);
    time.steps = whole(6);
    time.time_ms = parse_number(record.fields[7], at(7));
    time.origin = text(8);
    time.remark = record.fields[9];
    if (!(time.time_ms > 0) || std::isinf(time.time_ms)) {
      throw InputError(
          fmt::format("{}: found {}; accepted is a positive number", at(7), record.fields[7]));
    }
    if (i > 1 && text(0) != result.source) {
      throw InputError(at(0) + ": one file holds one source");
    }
    result.source = text(0);
    for (const PublishedTime& other : result.times) {
      if (other.method == time.method && other.samples == time.samples &&
          other.steps == time.steps && other.origin == time.origin) {
        throw InputError(fmt::format(
            "{}:{}: the time of '{}' for {} samples and {} steps in '{}' "
            "is given twice",
            path.string(), record.line, time.method, time.samples, time.steps, time.origin));
      }
    }
    result.times.push_back(std::move(time));
  }
  if (result.times.empty()) throw InputError(fmt::format("{}: no rows", path.string()));
  return result;
}

}  // namespace occlab
