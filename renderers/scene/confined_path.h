#pragma once

#include <filesystem>
#include <string>

namespace occlab {

/// The file that a scene or a configuration in `folder` names: `named`, relative to `folder`. With
/// symbolic links followed it must lie in `folder` or below it, or in or below one of the folders
/// in the environment variable OCCLAB_ALLOW_OUTSIDE, which are separated by colons; else a file
/// from anywhere could show what its author must not see. Throws InputError that begins with
/// `where`. The file itself need not exist.
std::filesystem::path confined_path(const std::filesystem::path& folder,
                                    const std::filesystem::path& named, const std::string& where);

}  // namespace occlab
