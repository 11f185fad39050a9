#pragma once

#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace occlab {

/// One measured number: a row of measurements.csv.
///
/// Names that the tables know: metric `noise` and `bias`; `time_ms.PASS` (value: the median, lower
/// and upper: the quartiles) and `time_ratio.PASS` (median of the pairwise ratios to the baseline,
/// interval between order statistics); `METRIC_ratio.A/B` (METRIC of method A over that of method
/// B; interval: Student's of n - 1 degrees of freedom on a logarithmic scale) and
/// `bias_squared_difference.A/B` (A's less B's; Student's interval). `budget_...` and
/// `failure_...` are parts of the error (error_budget.h). Every other metric is an accuracy.
/// Elsewhere lower and upper bound a 95% interval.
struct Measurement {
  std::string experiment;
  std::string scene;
  std::string view;
  std::string resolution;  ///< "1280x720"
  std::string probe;       ///< with its settings, as the tables print it
  std::string method;
  /// Name and value, without `seed`; values are not empty. A file keeps one order for all rows.
  std::vector<std::pair<std::string, std::string>> parameters;
  std::string seed;   ///< a number, or "all" for statistics over the seeds
  std::string stage;  ///< "unfiltered", "filtered" or "" where it does not apply
  std::string metric;
  std::string unit;             ///< "" if it has none
  std::optional<double> value;  ///< not NaN; none: `reason` says why
  std::optional<double> lower;  ///< lower and upper come together
  std::optional<double> upper;
  long n = 0;                      ///< how many seeds, pixels or repetitions are behind the value
  std::string device;              ///< "llvmpipe (software)"; times of two are never compared
  std::string clock;               ///< times: the clock that was used
  std::vector<std::string> cells;  ///< ids of the cells it was measured on
  std::string reference_cell;      ///< id, or ""
  std::string reason;              ///< why there is no value

  bool operator==(const Measurement&) const = default;
};

/// Adds the names of `values` that are not in `names` yet, each after the one it follows in
/// `values`: the order of columns.
void merge_names(std::vector<std::string>& names,
                 const std::vector<std::pair<std::string, std::string>>& values);

/// The value of a parameter, nullptr if the measurement does not have it.
const std::string* find_parameter(const Measurement& measurement, std::string_view name);

/// RFC 4180, one column per field, one `parameter.NAME` column for each parameter that any row has;
/// numbers are the shortest text that reads back exactly, a missing number is empty. Throws
/// InputError where a row breaks the rules above.
std::string measurements_to_csv(const std::vector<Measurement>& measurements);
/// Throws InputError "NAME:LINE: ..." for anything measurements_to_csv would not have written.
std::vector<Measurement> measurements_from_csv(std::string_view text, const std::string& name);

/// Writes rows to a file as they come. The file is complete or as it was: it is written beside
/// `path`, synced and renamed. Throws DeviceError with the path and the system's reason, and
/// InputError for rows as measurements_to_csv does.
class MeasurementsFile {
 public:
  /// `parameters`: the names that rows may have, in the order of the columns.
  MeasurementsFile(std::filesystem::path path, std::vector<std::string> parameters);
  /// Without finish() nothing is left.
  ~MeasurementsFile();
  MeasurementsFile(const MeasurementsFile&) = delete;
  MeasurementsFile& operator=(const MeasurementsFile&) = delete;

  void add(const std::vector<Measurement>& rows);
  void finish();
  std::size_t rows() const { return rows_; }

 private:
  void write(const std::string& text);

  std::filesystem::path path_;
  std::filesystem::path temporary_;
  std::vector<std::string> parameters_;
  std::FILE* file_ = nullptr;
  std::size_t rows_ = 0;
};

/// Throws DeviceError with the path and the system's reason; complete or as it was.
void write_measurements(const std::filesystem::path& path,
                        const std::vector<Measurement>& measurements);
std::vector<Measurement> read_measurements(const std::filesystem::path& path);

}  // namespace occlab
