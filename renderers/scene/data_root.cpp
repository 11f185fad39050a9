#include "renderers/scene/data_root.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "renderers/scene/error.h"

namespace occlab {
namespace fs = std::filesystem;

fs::path data_root() {
  const char* root = std::getenv("OCCLAB_DATA");
  return root != nullptr && *root != '\0' ? fs::path(root) : fs::path(OCCLAB_SOURCE_DIR);
}

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(data_root() / "scenes", ignored)) {
    const std::string name = entry.path().filename().string();
    if (fs::is_regular_file(entry.path() / (name + ".glb"), ignored)) names.push_back(name);
  }
  std::ranges::sort(names);
  return names;
}

bool is_path(const std::string& name_or_path) {
  return name_or_path.find('/') != std::string::npos || fs::path(name_or_path).has_extension();
}

fs::path scene_path(const std::string& name_or_path) {
  if (is_path(name_or_path)) return name_or_path;
  const std::vector<std::string> names = scene_names();
  if (std::ranges::find(names, name_or_path) == names.end()) {
    throw InputError(fmt::format(
        "unknown scene '{}' (looked in {}){}; a path of a .glb or .gltf "
        "is accepted too",
        name_or_path, (data_root() / "scenes").string(), accepted_words(name_or_path, names)));
  }
  return data_root() / "scenes" / name_or_path / (name_or_path + ".glb");
}

}  // namespace occlab
