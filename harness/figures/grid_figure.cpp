#include <fmt/format.h>

#include <algorithm>

#include "harness/figures/figure_parts.h"
#include "harness/figures/shrink.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr int page_width = 2600;  // pixels; wider grids show smaller frames
constexpr int frame_line = 1;     // pixels

void check(const GridFigure& figure) {
  require_some(figure.columns.size(), "columns");
  require_some(figure.rows.size(), "rows");
  if (figure.images.size() != figure.columns.size() * figure.rows.size()) {
    throw InputError(fmt::format("a grid of {} columns and {} rows with {} images",
                                 figure.columns.size(), figure.rows.size(), figure.images.size()));
  }
  const Image& first = figure.images.front();
  for (const Image& image : figure.images) require_display(image, "grid", first);
  for (const GridHeading& row : figure.rows) {
    if (row.rectangle) require_inside(*row.rectangle, row.label, first);
  }
}

/// The width of the headings left of the rows; a single row of frames needs none.
int heading_width(const GridFigure& figure, const FigureSizes& sizes) {
  return figure.rows.size() > 1 ? 10 * sizes.text : 0;
}

int shrink_factor(const GridFigure& figure) {
  const int columns = int(figure.columns.size());
  const int width = figure.images.front().width();
  int factor = 1;
  while (columns * width / factor > page_width && factor < 8) ++factor;
  return factor;
}

Image heading_block(const GridHeading& heading, int number, const FigureSizes& sizes, int width) {
  std::vector<Image> parts;
  if (number > 0) parts.push_back(number_badge(number, sizes.title));
  parts.push_back(
      text_block(heading.label, {sizes.text, Weight::bold, heading.colour}, width - sizes.gap / 2));
  if (!heading.note.empty()) {
    parts.push_back(text_block(heading.note, {sizes.text}, width - sizes.gap / 2));
  }
  const Image text = stack(parts, sizes.gap / 4);
  Image block = blank(width, text.height());
  paste(block, 0, 0, text);
  return block;
}

/// A closeup that fills a panel's width as far as whole magnifications do.
Image closeup(const Image& image, const Rectangle& rectangle, int width) {
  const int magnification = std::max(1, width / rectangle.width);
  const Image enlarged = crop(image, rectangle, magnification);
  return centred(enlarged, width, enlarged.height());
}

class GridPage {
 public:
  explicit GridPage(const GridFigure& figure)
      : figure_(figure),
        factor_(shrink_factor(figure)),
        panel_width_(figure.images.front().width() / factor_),
        sizes_(int(figure.columns.size()) * panel_width_) {}

  Image draw() const {
    std::vector<Image> rows = {header()};
    int number = 0;
    for (std::size_t r = 0; r < figure_.rows.size(); ++r) {
      const GridHeading& row = figure_.rows[r];
      if (row.rectangle) ++number;
      rows.push_back(panels(r, row.rectangle ? number : 0));
    }
    return page(figure_.title, {stack(rows, sizes_.gap / 2)}, figure_.caption, sizes_);
  }

 private:
  /// The labels of the columns, which may take several lines.
  Image header() const {
    std::vector<Image> blocks = {blank(std::max(1, heading_width(figure_, sizes_)), 1)};
    for (const GridHeading& column : figure_.columns) {
      const Image tab = label_tab(column.label, column.colour, sizes_);
      Image block = blank(framed_width(), 1);
      block = stack({tab, block}, 0);
      blocks.push_back(block);
    }
    if (heading_width(figure_, sizes_) == 0) blocks.erase(blocks.begin());
    return beside(blocks, sizes_.gap / 2);
  }

  Image panels(std::size_t r, int number) const {
    const GridHeading& row = figure_.rows[r];
    std::vector<Image> blocks;
    if (const int width = heading_width(figure_, sizes_); width > 0) {
      blocks.push_back(heading_block(row, number, sizes_, width));
    }
    for (std::size_t c = 0; c < figure_.columns.size(); ++c) {
      const Image& image = figure_.images[r * figure_.columns.size() + c];
      const Image shown = row.rectangle ? closeup(image, *row.rectangle, panel_width_)
                                        : shrink(marked(image), factor_);
      blocks.push_back(framed(shown, frame_line, ink));
    }
    return beside(blocks, sizes_.gap / 2);
  }

  Image marked(const Image& image) const {
    std::vector<Rectangle> rectangles;
    for (const GridHeading& row : figure_.rows) {
      if (row.rectangle) rectangles.push_back(*row.rectangle);
    }
    return rectangles.empty() ? image : draw_rectangles(image, rectangles);
  }

  int framed_width() const { return panel_width_ + 2 * frame_line; }

  const GridFigure& figure_;
  int factor_;
  int panel_width_;
  FigureSizes sizes_;
};

}  // namespace

Image grid_figure(const GridFigure& figure) {
  check(figure);
  return GridPage(figure).draw();
}

}  // namespace occlab
