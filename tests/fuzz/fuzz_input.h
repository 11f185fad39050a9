#pragma once

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "renderers/scene/temporary_folder.h"

namespace occlab::fuzz {

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// A folder of this process, removed at its end. $TMPDIR should be in memory.
class Folder {
 public:
  const std::filesystem::path& path() const { return folder_.path(); }

  std::filesystem::path write(const std::string& name, std::string_view bytes) const {
    const std::filesystem::path file = folder_ / name;
    std::ofstream stream(file, std::ios::binary | std::ios::trunc);
    stream.write(bytes.data(), std::streamsize(bytes.size()));
    return file;
  }

 private:
  TemporaryFolder folder_{"occlab-fuzz-"};
};

/// Two files in one input: what stands before the first NUL and what follows it.
struct TwoParts {
  std::string_view first;
  std::string_view second;
};
inline TwoParts split(std::string_view input) {
  const std::size_t nul = input.find('\0');
  if (nul == std::string_view::npos) return {input, {}};
  return {input.substr(0, nul), input.substr(nul + 1)};
}

/// What was accepted must be usable; anything else is a bug that the fuzzer is to report.
inline void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace occlab::fuzz
