#include "harness/report/page.h"

#include <string_view>
#include <utility>

namespace occlab::report {
namespace {

using nlohmann::json;

void embed(std::string& page, std::string_view marker, const json& data) {
  page.replace(page.find(marker), marker.size(), inline_json(data));
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

std::string report_page(const json& data) {
  std::string page(page_html);
  embed(page, "/*occlab-data*/", data);
  return page;
}

std::string history_page(json data) {
  json values = std::move(data["values"]);
  data.erase("values");
  std::string page(history_html);
  // From the end, so that no marker is looked for in data.
  embed(page, "/*occlab-values*/", values);
  embed(page, "/*occlab-data*/", data);
  return page;
}

}  // namespace occlab::report
