#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace occlab::report {

struct ReportOptions {
  std::filesystem::path results;
  double megabytes = 25.0;  ///< that the report's folder may take (10^6 bytes)
};

struct WrittenReport {
  std::filesystem::path index;        ///< RESULTS/report/index.html
  std::vector<std::string> problems;  ///< of the run, as the page shows them
  std::vector<std::string> left_out;  ///< images that did not fit
  std::size_t bytes = 0;              ///< of the whole folder
};

/// Writes RESULTS/report: a page for browsers that needs neither a server nor a network. It is
/// there as a whole or as it was. Nothing else in RESULTS changes: a damaged or missing cell is
/// shown as such, and a run without run.json as incomplete.
///
/// Throws InputError where RESULTS is no results folder, is of an unknown schema, or has a folder
/// `report` that is not one of ours; DeviceError where nothing can be written.
WrittenReport write_report(const ReportOptions& options);

}  // namespace occlab::report
