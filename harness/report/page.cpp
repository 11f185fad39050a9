#include "harness/report/page.h"

#include <string_view>

namespace occlab::report {
namespace {

using nlohmann::json;

constexpr std::string_view data_marker = "/*occlab-data*/";

std::string page_with(std::string_view html, const json& data) {
  std::string page(html);
  const std::size_t marker = page.find(data_marker);
  page.replace(marker, data_marker.size(), inline_json(data));
  return page;
}

}  // namespace

std::string inline_json(const json& data) {
  const std::string text = data.dump(-1, ' ', true, json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string report_page(const json& data) { return page_with(page_html, data); }

std::string history_page(const json& data) { return page_with(history_html, data); }

}  // namespace occlab::report
