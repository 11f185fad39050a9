#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace occlab::report {

/// Copies RESULTS/figures/NAME.png, made narrow enough for a page, to FOLDER/figures/NAME.jpg, for
/// each of `figures` (figures_of): adds `file`, `width` and `height`, or `missing`: why there is
/// none.
void copy_figures(nlohmann::json& figures, const std::filesystem::path& results,
                  const std::filesystem::path& folder);

}  // namespace occlab::report
