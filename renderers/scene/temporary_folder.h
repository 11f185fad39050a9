#pragma once

#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "renderers/scene/error.h"

namespace occlab {

/// A fresh folder below the system's one for temporary files, gone with its content at the end of
/// this object unless it is to be kept.
class TemporaryFolder {
 public:
  /// Throws DeviceError with the path and the system's reason.
  explicit TemporaryFolder(std::string_view prefix = "occlab-") {
    constexpr std::string_view places_for_mkdtemp = "XXXXXX";
    std::string name = std::filesystem::temp_directory_path() / prefix;
    name += places_for_mkdtemp;
    if (::mkdtemp(name.data()) == nullptr) {
      throw DeviceError(name + ": cannot be created: " + std::strerror(errno));
    }
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!kept_) std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(std::string_view name) const { return path_ / name; }
  void keep() { kept_ = true; }

 private:
  std::filesystem::path path_;
  bool kept_ = false;
};

}  // namespace occlab
