#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "renderers/scene/image.h"

namespace occlab {

// What the measurements demand of their images. `name` is what an error calls the image.

/// Indices (y * width + x) of the pixels where the one-channel mask exceeds 0.5, in order.
/// InputError for other numbers of channels, values that are not finite, and no such pixel.
std::vector<std::size_t> foreground_pixels(const Image& mask);

/// InputError unless `image` has the size of `like` and `channels` channels.
void require_shape(const Image& image, std::string_view name, const Image& like, int channels);

/// InputError unless the foreground's values are finite (and, where asked, not negative).
void require_finite(const Image& image, std::string_view name,
                    std::span<const std::size_t> foreground);
void require_finite_non_negative(const Image& image, std::string_view name,
                                 std::span<const std::size_t> foreground);

/// Foreground pixels with a channel that is not finite.
std::size_t count_non_finite(const Image& image, std::span<const std::size_t> foreground);

/// Mean Rec.709 luminance (of one channel: mean value) over the foreground.
double mean_luminance(const Image& image, std::span<const std::size_t> foreground);

}  // namespace occlab
