#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace occlab {

/// SHA-256 as 64 lower-case hex digits.
std::string sha256_text(std::string_view text);
/// Throws InputError naming the file when it cannot be opened, DeviceError when reading it fails.
std::string sha256_file(const std::filesystem::path& path);

/// The whole file. Throws as sha256_file does.
std::string read_text(const std::filesystem::path& path);

/// The file is complete and on the disk, or as it was: written beside `path`, synced and renamed.
/// Throws DeviceError with the path and the system's reason.
void write_text_atomically(const std::filesystem::path& path, std::string_view text);

/// Creates `path` and what leads to it. Throws DeviceError with the path and the system's reason.
void create_folder(const std::filesystem::path& path);

/// Waits until a file's or a folder's contents are on the disk. Throws DeviceError.
void sync_path(const std::filesystem::path& path);

}  // namespace occlab
