#pragma once

#include <vector>

#include "harness/figures/colour_maps.h"
#include "renderers/scene/image.h"

namespace occlab {

// A figure is put together from blocks: display-referred images with three channels on white
// paper. A block without pixels takes no room, and no gap.

inline constexpr DisplayColour paper = {1.0f, 1.0f, 1.0f};
inline constexpr DisplayColour ink = {0.1f, 0.1f, 0.1f};

enum class Placement { start, centre };

Image blank(int width, int height, const DisplayColour& colour = paper);

/// Fills the part of the rectangle that lies inside the image.
void fill(Image& image, int x, int y, int width, int height, const DisplayColour& colour);

/// Copies `block` into `image`; it must fit.
void paste(Image& image, int x, int y, const Image& block);

/// Blocks from top to bottom, from left to right.
Image stack(const std::vector<Image>& blocks, int gap, Placement placement = Placement::start);
Image beside(const std::vector<Image>& blocks, int gap, Placement placement = Placement::start);

/// The block in the middle of an area of that size (or its own, where that is larger).
Image centred(const Image& block, int width, int height, const DisplayColour& colour = paper);

/// The block with `thickness` pixels of colour on every side.
Image framed(const Image& block, int thickness, const DisplayColour& colour);

}  // namespace occlab
