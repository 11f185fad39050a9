#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "renderers/scene/limits.h"

namespace occlab {

/// A file's bytes, wherever they are.
struct ByteSource {
  std::uint64_t size = 0;
  /// Fills the span from `offset`; they lie within the size. False if reading fails.
  std::function<bool(std::uint64_t offset, std::span<std::byte>)> read;
};

ByteSource bytes_in_memory(std::span<const std::byte> bytes);

// Checks of what the libraries that decode images believe without looking. All throw InputError
// that begins with `where`.

/// OpenEXR takes memory of the size that an attribute or a tile claims, and walks chunk by chunk
/// through a window of any height. Refused are attributes beyond the file's end, windows beyond
/// `most_pixels`, huge tiles and deep images.
void check_exr_header(const ByteSource& file, Limit most_pixels, const std::string& where);

/// OpenImageIO jumps over its own strings, which then leak, where a PNG ends too early. Chunks must
/// lie within the file, the first be IHDR and the last IEND.
void check_png_chunks(const ByteSource& file, const std::string& where);

}  // namespace occlab
