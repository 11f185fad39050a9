#include "renderers/scene/limited_json.h"

#include <fmt/format.h>

#include <cstdint>

#include "renderers/scene/error.h"
#include "renderers/scene/limits.h"

namespace occlab {
namespace {

using nlohmann::json;

/// By brackets and commas outside strings: for JSON they tell depth and number of values. What is
/// none may be refused here or by the parser.
void check_size(std::string_view text, const std::string& where) {
  std::uint64_t depth = 0;
  std::uint64_t values = 1;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') in_string = !in_string;
    if (in_string) {
      if (c == '\\') ++i;
    } else if (c == '[' || c == '{') {
      require_within(Limit::nesting, ++depth, "or more levels of nested JSON", where);
      ++values;
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    } else if (c == ',') {
      ++values;
    }
  }
  require_within(Limit::json_values, values, "JSON values", where);
}

}  // namespace

json parse_limited_json(std::string_view text, const std::string& where) {
  check_size(text, where);
  try {
    return json::parse(text);
  } catch (const json::exception& error) {
    throw InputError(fmt::format("{}: {}", where, error.what()));
  }
}

json parse_limited_json_or_discard(std::string_view text) {
  try {
    check_size(text, "");
    return json::parse(text, nullptr, false);
  } catch (const InputError&) {
    return json(json::value_t::discarded);
  }
}

}  // namespace occlab
