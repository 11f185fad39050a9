#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace occlab {

/// The file that a shell would start for `name`, symbolic links followed; a name with a '/' is a
/// path. Throws InputError, which calls it `--blender`, where there is no such program.
std::filesystem::path find_blender(const std::string& name);

/// Runs a Blender without a shell; returns its exit code. Its folder is first on its PATH: Debian's
/// Blender takes its Python modules from beside the first python3 there, and those of a virtual
/// environment or of pyenv lack the numpy that its scripts need. What it prints goes to `log`, or
/// where this program's goes if that is empty. Throws DeviceError where it cannot be started or
/// ends by a signal, Interrupted (having ended it) where this program gets one.
int run_blender(const std::filesystem::path& blender, std::vector<std::string> arguments,
                const std::filesystem::path& log = {});

}  // namespace occlab
