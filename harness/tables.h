#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "harness/comparisons.h"
#include "harness/measurements.h"

namespace occlab {

enum class Alignment { left, right };

struct TableColumn {
  std::string name;
  std::string unit;  ///< "" if it has none
  Alignment alignment = Alignment::left;
};

struct TableNumber {
  double value = 0.0;
  std::optional<double> lower;  ///< lower and upper come together
  std::optional<double> upper;
  bool winner = false;  ///< resolved as better than all it is to be compared with
};

/// A number that does not exist, and why.
struct TableMissing {
  std::string reason;
};

/// Text is plain: the formats escape it.
using TableCell = std::variant<std::string, TableNumber, TableMissing>;

struct Table {
  std::string name;  ///< [a-z0-9_]+, the file's name
  std::string title;
  std::vector<TableColumn> columns;
  std::vector<std::vector<TableCell>> rows;  ///< each as long as `columns`
  std::vector<std::string> notes;
};

// Tables are pure functions of measurements. A row is a method and its parameters (and scene, view,
// probe, resolution); what is the same everywhere becomes a note instead of a column. Only rows of
// seed "all" count. A number is marked as winner where its row is resolved as better than every row
// of another method under the same conditions, by `comparisons`, and nowhere without them.

/// Accuracy metrics at one stage ("unfiltered", "filtered"), mean over the seeds with interval.
/// `comparisons`: compare_accuracy() of the same measurements and stage.
Table accuracy_table(const std::vector<Measurement>& measurements, const std::string& stage,
                     const Comparisons& comparisons = {});

/// How bright the pictures themselves are: means over the seeds with intervals, at one stage.
Table brightness_table(const std::vector<Measurement>& measurements, const std::string& stage);

/// Noise and bias at one stage, with intervals. `comparisons`: compare_noise().
Table noise_table(const std::vector<Measurement>& measurements, const std::string& stage,
                  const Comparisons& comparisons = {});

/// Every comparison of a family with its interval, adjusted p-value and verdict: "a < b", "a > b",
/// "equal", "unresolved" or "could not tell: REASON"; and the better method, where the verdict and
/// the metric say which it is. Has no row where there is nothing to compare.
Table comparisons_table(const Comparisons& comparisons, std::string name, std::string title);

/// Every METRIC_ratio.A/B as the statement "METRIC A > METRIC B", which holds where the whole
/// interval, corrected after Holm over all statements, is above 1, does not hold where it is below,
/// and is unresolved otherwise.
Table orderings_table(const std::vector<Measurement>& measurements);

}  // namespace occlab
