#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "harness/report/assets.h"

namespace occlab::report {

/// JSON that may stand inside a <script> of a page: no '<' can end it or begin a comment.
std::string inline_json(const nlohmann::json& data);

/// The text of index.html with its data in it; of a history, "values" stand last in the file. The
/// page needs its script and page_style beside it: page_script as app.js for the report,
/// history_script as history.js for the history.
std::string report_page(const nlohmann::json& data);
std::string history_page(nlohmann::json data);

}  // namespace occlab::report
