#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "harness/history/series.h"
#include "harness/history/sqlite.h"

namespace occlab::history {

struct DashboardOptions {
  std::filesystem::path folder;
  std::string project = "occlab";
  MinimumEffects minimum;  ///< the least steps that are listed
};

struct WrittenDashboard {
  std::filesystem::path index;
  std::size_t runs = 0;
  std::size_t series = 0;
  std::size_t steps = 0;
  std::size_t worse = 0;  ///< steps that are WORSE and not marked as intended
  std::size_t bytes = 0;
};

/// Writes FOLDER: a page for browsers that needs neither a server nor a network, with every series
/// over all runs, its steps and the small pictures. What is there is replaced when all is written.
/// Throws InputError where FOLDER holds something that is not a page of ours, or the history no
/// run.
WrittenDashboard write_dashboard(const Sqlite& database, const DashboardOptions& options);

}  // namespace occlab::history
