#include "harness/figures/shrink.h"

#include <algorithm>

namespace occlab {

Image shrink(const Image& image, int factor) {
  Image small(std::max(1, image.width() / factor), std::max(1, image.height() / factor), 3);
  for (int y = 0; y < small.height(); ++y) {
    for (int x = 0; x < small.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        float sum = 0.0f;
        int count = 0;
        for (int v = y * factor; v < std::min((y + 1) * factor, image.height()); ++v) {
          for (int u = x * factor; u < std::min((x + 1) * factor, image.width()); ++u, ++count) {
            sum += image.at(u, v, c);
          }
        }
        small.at(x, y, c) = sum / float(count);
      }
    }
  }
  return small;
}

}  // namespace occlab
