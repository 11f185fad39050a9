#include "renderers/scene/image_size.h"

#include <fmt/format.h>

#include <algorithm>

#include "renderers/scene/error.h"

namespace occlab {

void require_image_size(const OIIO::ImageSpec& spec, std::uint64_t file_bytes, Limit most_pixels,
                        const std::string& where) {
  if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0 || spec.depth > 1 || spec.deep) {
    throw InputError(
        fmt::format("{}: the image is {}x{} with {} channels{}; at least 1x1 with one channel, and "
                    "flat, is needed",
                    where, spec.width, spec.height, spec.nchannels,
                    spec.depth > 1 || spec.deep ? " and is deep" : ""));
  }
  const std::string size = fmt::format("{}: {}x{}", where, spec.width, spec.height);
  const std::uint64_t pixels =
      saturating_multiply(std::uint64_t(spec.width), std::uint64_t(spec.height));
  require_within(most_pixels, pixels, "pixels", size);
  const auto channels = std::uint64_t(spec.nchannels);
  require_within(Limit::image_channels, channels, "channels", size);
  const std::uint64_t values = saturating_multiply(pixels, channels);
  require_within(Limit::image_bytes, saturating_multiply(values, sizeof(float)), "bytes in memory",
                 size);
  // A header of a hundred bytes may claim gigabytes.
  const std::uint64_t stored = saturating_multiply(pixels, std::uint64_t(spec.pixel_bytes(true)));
  const std::uint64_t each = stored / std::max<std::uint64_t>(file_bytes, 1);
  require_within(Limit::image_expansion, each, "bytes for each byte of the file", size);
}

}  // namespace occlab
