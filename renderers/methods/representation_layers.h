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

/// The 16 coefficients of S3HO's two RGBA32UI targets, one a channel, view space.
Image unpack_sh(const Texture& low, const Texture& high);

/// Writes 16-channel coefficients into S3HO's two targets, as halves.
void upload_packed_sh(const Image& coefficients, const Framebuffer& target);

/// k_A = (2/sqrt(pi)) c_0 of a 16-channel image.
Image sh_ambient_occlusion(const Image& coefficients);

}  // namespace occlab
