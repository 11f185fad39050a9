#pragma once

#include "renderers/gl/texture.h"
#include "renderers/methods/representation.h"
#include "renderers/scene/image.h"

namespace occlab {

/// The 16 coefficients as values, and back.
Sh4 sh_of(const Representation::Values& values);
Representation::Values values_of(const Sh4& sh);

/// `count` channels of an image, from `first` on.
Image channels_of(const Image& image, int first, int count);

/// Value by value; both have one size and as many channels.
Image sum_of(Image a, const Image& b);
Image difference(Image a, const Image& b);

/// Representation::upload and download of what one float texture holds.
void upload_floats(const Image& values, const Framebuffer& target);
Image download_floats(const Framebuffer& target, int channels);

/// The same of 16 coefficients, as halves in S3HO's two RGBA32UI targets.
void upload_packed_sh(const Image& coefficients, const Framebuffer& target);
Image download_packed_sh(const Framebuffer& target, int channels);

/// Sets negative channels, which an SH product can give, to 0 and counts their pixels; a NaN stays.
Image clamp_negative(Image radiance, std::size_t& negative_pixels);

/// k_A = (2/sqrt(pi)) c_0 of a 16-channel image.
Image sh_ambient_occlusion(const Image& coefficients);

}  // namespace occlab
