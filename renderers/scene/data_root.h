#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace occlab {

/// The folder that holds scenes/: $OCCLAB_DATA, or the source tree this program was built from.
std::filesystem::path data_root();

/// Names of the scenes that come with occlab: every <root>/scenes/NAME/NAME.glb, sorted.
std::vector<std::string> scene_names();

/// A scene's file. A text with a '/' or an extension is a path and returned as it is; any other is
/// a name of scene_names(). Throws InputError listing the names.
std::filesystem::path scene_path(const std::string& name_or_path);

/// Whether a text that may be a name or a path is a path: it has a '/' or an extension.
bool is_path(const std::string& name_or_path);

}  // namespace occlab
