#pragma once

#include "renderers/scene/image.h"

namespace occlab {

/// A display-referred RGB image made smaller by a whole factor: means of blocks, those at the right
/// and lower edge of what is there. At least 1x1.
Image shrink(const Image& image, int factor);

}  // namespace occlab
