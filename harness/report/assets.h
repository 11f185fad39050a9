#pragma once

#include <string_view>

namespace occlab::report {

// The pages as they were bundled (harness/report/web) and the linker put them into the program: the
// report of a run and the history of a project, which share a style sheet.
extern const std::string_view page_html;
extern const std::string_view page_script;
extern const std::string_view page_style;
extern const std::string_view history_html;
extern const std::string_view history_script;

}  // namespace occlab::report
