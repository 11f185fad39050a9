#include "harness/toml_limits.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "renderers/scene/limits.h"

namespace occlab {
namespace {

/// Where a string that begins at `i` ends: behind its last quote, or at the end of the line or the
/// text where it is not closed.
std::size_t end_of_string(std::string_view text, std::size_t i) {
  const char quote = text[i];
  const std::string three(3, quote);
  const bool lines = text.substr(i, 3) == three;
  for (i += lines ? 3 : 1; i < text.size(); ++i) {
    if (text[i] == '\\' && quote == '"') {
      ++i;
    } else if (!lines && (text[i] == quote || text[i] == '\n')) {
      return i + 1;
    } else if (lines && text.substr(i, 3) == three) {
      // Up to two quotes before the closing ones belong to the string.
      return std::min(text.find_first_not_of(quote, i), i + 5);
    }
  }
  return text.size();
}

}  // namespace

// Counts brackets and the dots of keys, of which numbers have one, too. What is no TOML may be
// refused here or by the parser.
void check_toml_text(std::string_view text, const std::string& where) {
  require_within(Limit::config_bytes, text.size(), "bytes", where);
  std::vector<std::uint64_t> brackets;  // the depth before each that is open
  std::uint64_t depth = 0;
  std::uint64_t dots = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"' || c == '\'') {
      i = std::min(end_of_string(text, i), text.size()) - 1;
    } else if (c == '#') {
      i = std::min(text.find('\n', i), text.size() - 1);
      dots = 0;
    } else if (c == '.') {
      ++dots;
    } else if (c == '[' || c == '{') {
      brackets.push_back(depth);
      depth += dots + 1;
      dots = 0;
    } else if ((c == ']' || c == '}') && !brackets.empty()) {
      depth = brackets.back();
      brackets.pop_back();
      dots = 0;
    } else if (c == ',' || c == '\n') {
      dots = 0;
    }
    require_within(Limit::nesting, depth + dots, "or more levels of nested TOML", where);
  }
}

}  // namespace occlab
