#include "renderers/scene/error.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <vector>

namespace occlab {
namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t substitute = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substitute, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string accepted_words(std::string_view found, std::span<const std::string> accepted) {
  const std::string list = fmt::format("accepted: {}", fmt::join(accepted, ", "));
  const auto distance = [&](const std::string& word) { return edit_distance(found, word); };
  const auto closest = std::ranges::min_element(accepted, {}, distance);
  const std::size_t farthest = std::max<std::size_t>(2, found.size() / 3);
  // As far as the word is long, nothing of it is left.
  if (closest == accepted.end() || distance(*closest) > farthest ||
      distance(*closest) >= found.size()) {
    return "; " + list;
  }
  return fmt::format("; did you mean '{}'? {}", *closest, list);
}

}  // namespace occlab
