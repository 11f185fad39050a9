#include "harness/figures/canvas.h"

#include <algorithm>
#include <cassert>

namespace occlab {
namespace {

int gaps(const std::vector<Image>& blocks, int gap) {
  const auto filled = std::ranges::count_if(blocks, [](const Image& b) { return !b.empty(); });
  return filled > 0 ? gap * static_cast<int>(filled - 1) : 0;
}

int offset(int room, int size, Placement placement) {
  return placement == Placement::centre ? (room - size) / 2 : 0;
}

}  // namespace

Image blank(int width, int height, const DisplayColour& colour) {
  Image image(width, height, 3);
  fill(image, 0, 0, width, height, colour);
  return image;
}

void fill(Image& image, int x, int y, int width, int height, const DisplayColour& colour) {
  for (int row = std::max(y, 0); row < std::min(y + height, image.height()); ++row) {
    for (int column = std::max(x, 0); column < std::min(x + width, image.width()); ++column) {
      std::ranges::copy(colour, image.pixel(column, row).begin());
    }
  }
}

void paste(Image& image, int x, int y, const Image& block) {
  if (block.empty()) return;
  assert(image.channels() == block.channels());
  assert(x >= 0 && y >= 0 && x + block.width() <= image.width());
  assert(y + block.height() <= image.height());
  const std::size_t row_values = std::size_t(block.width()) * std::size_t(block.channels());
  for (int row = 0; row < block.height(); ++row) {
    std::copy_n(block.pixel(0, row).data(), row_values, image.pixel(x, y + row).data());
  }
}

Image stack(const std::vector<Image>& blocks, int gap, Placement placement) {
  int width = 0;
  int height = gaps(blocks, gap);
  for (const Image& block : blocks) {
    width = std::max(width, block.width());
    height += block.height();
  }
  Image result = blank(width, height);
  int y = 0;
  for (const Image& block : blocks) {
    if (block.empty()) continue;
    paste(result, offset(width, block.width(), placement), y, block);
    y += block.height() + gap;
  }
  return result;
}

Image beside(const std::vector<Image>& blocks, int gap, Placement placement) {
  int width = gaps(blocks, gap);
  int height = 0;
  for (const Image& block : blocks) {
    width += block.width();
    height = std::max(height, block.height());
  }
  Image result = blank(width, height);
  int x = 0;
  for (const Image& block : blocks) {
    if (block.empty()) continue;
    paste(result, x, offset(height, block.height(), placement), block);
    x += block.width() + gap;
  }
  return result;
}

Image centred(const Image& block, int width, int height, const DisplayColour& colour) {
  Image result = blank(std::max(width, block.width()), std::max(height, block.height()), colour);
  paste(result, (result.width() - block.width()) / 2, (result.height() - block.height()) / 2,
        block);
  return result;
}

Image framed(const Image& block, int thickness, const DisplayColour& colour) {
  return centred(block, block.width() + 2 * thickness, block.height() + 2 * thickness, colour);
}

}  // namespace occlab
