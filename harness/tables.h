#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "harness/measurements.h"
#include "harness/published.h"

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
// seed "all" count. No winner is marked.

/// Accuracy metrics at one stage ("unfiltered", "filtered"), mean over the seeds with interval.
Table accuracy_table(const std::vector<Measurement>& measurements, const std::string& stage);

/// Noise and bias at one stage, with intervals.
Table noise_table(const std::vector<Measurement>& measurements, const std::string& stage);

/// Median times of each pass with quartiles and the ratios to the baseline, beside the published
/// times of the same method, samples and steps and their ratios to `baseline`. Throws InputError
/// where times of several devices or clocks are mixed.
Table timing_table(const std::vector<Measurement>& measurements, const std::string& baseline,
                   const std::optional<PublishedTimes>& published);

/// Every METRIC_ratio.A/B as the statement "METRIC A > METRIC B", which holds where the whole
/// interval is above 1, does not hold where it is below, and is unresolved otherwise.
Table orderings_table(const std::vector<Measurement>& measurements);

}  // namespace occlab
