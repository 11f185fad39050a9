#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "harness/measurements.h"

namespace occlab {

/// run.json of an experiment with several scenes, views, resolutions or probes: it has `benches` in
/// the place of these. That of one is of schema 1.
inline constexpr int schema_of_several_benches = 2;

/// Tables are made of up to so many measurements, which takes some 0.25 GB of memory.
inline constexpr std::size_t most_rows_of_tables = 50'000;

/// Removes what a run makes, by name; anything else in the folder is the user's.
void remove_results(const std::filesystem::path& folder);

/// What runs have left in a results folder beside the cells.
class ResultsFolder {
 public:
  explicit ResultsFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::filesystem::path measurements() const { return folder_ / "measurements.csv"; }
  std::filesystem::path report() const { return folder_ / "run.json"; }

  /// What run.json says of the numbers in measurements.csv; nothing, and a warning, where the two
  /// do not belong together: a file was edited, or a run was killed between writing one and the
  /// other.
  nlohmann::json read_report(const std::function<void(std::string)>& warn) const;

  /// The rows of measurements.csv that are times, or all others.
  std::vector<Measurement> rows(bool times) const;

  bool has_outputs(bool figures) const;

  /// Removes what a process that was killed while it wrote outputs has left half-written beside
  /// them. Nobody else may be writing outputs.
  void remove_left_overs() const;

 private:
  std::filesystem::path folder_;
};

}  // namespace occlab
