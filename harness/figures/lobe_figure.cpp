#include <algorithm>
#include <cmath>

#include "harness/figures/figure_parts.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

void set(Image& image, int x, int y, const DisplayColour& colour) {
  if (x < 0 || y < 0 || x >= image.width() || y >= image.height()) return;
  std::ranges::copy(colour, image.pixel(x, y).begin());
}

/// A white ring with an ink edge on both sides, so that it shows on any ground.
void draw_ring(Image& image, const MarkedPoint& point, int radius, int thickness) {
  const int reach = radius + 2 * thickness;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const double off = std::abs(std::hypot(dx, dy) - radius);
      if (off > 1.5 * thickness) continue;
      set(image, point.x + dx, point.y + dy, off <= 0.6 * thickness ? paper : ink);
    }
  }
}

Image sphere_block(const SpherePanel& sphere, int width, const FigureSizes& sizes) {
  return stack({text_block(sphere.label, {sizes.text, Weight::bold}, width),
                centred(sphere.image, width, sphere.image.height()),
                text_block(sphere.note, {sizes.text}, width)},
               sizes.gap / 2, Placement::centre);
}

}  // namespace

Image draw_points(const Image& image, const std::vector<MarkedPoint>& points) {
  Image result = image;
  const FigureSizes sizes(image.width());
  const int radius = std::max(4, sizes.text / 3);
  const int thickness = std::max(1, sizes.text / 10);
  for (const MarkedPoint& point : points) {
    if (point.x < 0 || point.y < 0 || point.x >= image.width() || point.y >= image.height()) {
      throw InputError("a marked point is outside of the image");
    }
    draw_ring(result, point, radius, thickness);
    const Image label = text_block(point.label, {sizes.text, Weight::bold}, image.width());
    const Image tab = framed(framed(label, 2, paper), 1, ink);
    if (tab.width() > image.width() || tab.height() > image.height()) continue;
    const int x = std::clamp(point.x + radius + 2 * thickness, 0, image.width() - tab.width());
    const int y = std::clamp(point.y - radius - tab.height(), 0, image.height() - tab.height());
    paste(result, x, y, tab);
  }
  return result;
}

Image lobe_figure(const LobeFigure& figure) {
  require_some(figure.panels.size(), "panels");
  require_some(figure.spheres.size(), "spheres");
  const Image& first = figure.panels.front().image;
  for (const Panel& panel : figure.panels) require_display(panel.image, panel.label, first);
  int sphere_width = 0;
  for (const SpherePanel& sphere : figure.spheres) {
    require_display(sphere.image, sphere.label, sphere.image);
    sphere_width = std::max(sphere_width, sphere.image.width());
  }
  const FigureSizes sizes(first.width());
  // Spread over the width of the picture, so that notes have room.
  const int count = int(figure.spheres.size());
  const int room = (first.width() - (count - 1) * sizes.gap) / count;
  std::vector<Image> spheres;
  for (const SpherePanel& sphere : figure.spheres) {
    spheres.push_back(sphere_block(sphere, std::max(room, sphere_width), sizes));
  }
  std::vector<Image> content;
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    const Panel& panel = figure.panels[i];
    content.push_back(framed_panel(panel.label, panel.colour, panel.image, sizes));
    if (i == 0) content.push_back(grid(spheres, count, sizes.gap));
  }
  return page(figure.title, content, figure.caption, sizes);
}

}  // namespace occlab
