#pragma once

#include "renderers/gl/texture.h"
#include "renderers/scene/image.h"

namespace occlab {

/// `count` channels of an image, from `first` on.
Image channels_of(const Image& image, int first, int count);

/// The 16 coefficients of S3HO's two RGBA32UI targets, one a channel, view space.
Image unpack_sh(const Texture& low, const Texture& high);

/// k_A = (2/sqrt(pi)) c_0 of a 16-channel image.
Image sh_ambient_occlusion(const Image& coefficients);

}  // namespace occlab
