#include "renderers/scene/confined_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "renderers/scene/error.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

/// Absolute, without "..", symbolic links followed as far as the path exists.
fs::path resolved(const fs::path& path) { return fs::weakly_canonical(fs::absolute(path)); }

bool is_below(const fs::path& path, const fs::path& folder) {
  const auto [end, rest] = std::ranges::mismatch(folder, path);
  // A trailing slash is an empty last part.
  return end == folder.end() || (std::next(end) == folder.end() && end->empty());
}

std::vector<fs::path> allowed_folders() {
  std::vector<fs::path> folders;
  const char* text = std::getenv("OCCLAB_ALLOW_OUTSIDE");
  std::string_view rest = text == nullptr ? "" : text;
  while (!rest.empty()) {
    const std::string_view folder = rest.substr(0, rest.find(':'));
    if (!folder.empty()) folders.push_back(resolved(folder));
    rest.remove_prefix(std::min(folder.size() + 1, rest.size()));
  }
  return folders;
}

}  // namespace

fs::path confined_path(const fs::path& folder, const fs::path& named, const std::string& where) {
  const fs::path base = folder.empty() ? fs::current_path() : fs::absolute(folder);
  const fs::path path = (base / named).lexically_normal();
  try {
    const fs::path target = resolved(path);
    if (is_below(target, resolved(base))) return path;
    for (const fs::path& allowed : allowed_folders()) {
      if (is_below(target, allowed)) return path;
    }
  } catch (const fs::filesystem_error& error) {
    throw InputError(fmt::format("{}: '{}' cannot be looked up: {}", where, named.string(),
                                 error.code().message()));
  }
  throw InputError(fmt::format(
      "{}: '{}' lies outside the folder {} and is not read; accepted: a file in that folder or "
      "below it, or in a folder that the environment variable OCCLAB_ALLOW_OUTSIDE names",
      where, named.string(), base.lexically_normal().string()));
}

}  // namespace occlab
