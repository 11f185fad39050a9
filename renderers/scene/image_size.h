#pragma once

#include <OpenImageIO/imageio.h>

#include <cstdint>
#include <string>

#include "renderers/scene/limits.h"

namespace occlab {

/// What a file of `file_bytes` says of its image, before memory is taken for the pixels. Throws
/// InputError that begins with `where`: an image without pixels, with depth, beyond `most_pixels`
/// or the other limits of images.
void require_image_size(const OIIO::ImageSpec& spec, std::uint64_t file_bytes, Limit most_pixels,
                        const std::string& where);

}  // namespace occlab
