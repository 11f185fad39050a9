#pragma once

#include <string_view>

namespace occlab {

/// `git describe --always --dirty` of the source tree when it was built; "unknown" outside of git.
extern const std::string_view build_commit;
/// Hash of everything below renderers/: what decides a cell's pixels.
extern const std::string_view renderers_hash;
/// Hash of everything below harness/: what decides the numbers measured on a cell.
extern const std::string_view harness_hash;

}  // namespace occlab
