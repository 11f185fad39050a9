#pragma once

#include <string_view>

namespace occlab::report {

// The page as tools/ built it (cmake/report_page.cmake) and the linker put it into the program.
extern const std::string_view page_html;
extern const std::string_view page_script;
extern const std::string_view page_style;

}  // namespace occlab::report
