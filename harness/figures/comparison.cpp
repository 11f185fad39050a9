#include <algorithm>

#include "harness/figures/figure_parts.h"

namespace occlab {

Image comparison_figure(const ComparisonFigure& figure) {
  require_some(figure.panels.size(), "panels");
  const Image& first = figure.panels.front().image;
  for (const Panel& panel : figure.panels) require_display(panel.image, panel.label, first);
  const int columns = std::min(figure.columns, int(figure.panels.size()));
  const FigureSizes sizes(columns * first.width());
  std::vector<Image> panels;
  for (const Panel& panel : figure.panels) {
    panels.push_back(framed_panel(panel.label, panel.colour, panel.image, sizes));
  }
  return page(figure.title, {grid(panels, columns, sizes.gap)}, figure.caption, sizes);
}

}  // namespace occlab
