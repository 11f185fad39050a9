#pragma once

#include <filesystem>
#include <set>
#include <string>

namespace occlab::report {

/// Ids of the cells that the last run over a results folder planned, as it noted them in
/// RESULTS/progress (work_log.h) before it rendered. Empty where there is no such note, or none
/// that can be read: then nobody knows how many there would have been.
std::set<std::string> planned_cells(const std::filesystem::path& results);

}  // namespace occlab::report
