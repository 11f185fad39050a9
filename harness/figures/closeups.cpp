#include <fmt/format.h>

#include <algorithm>

#include "harness/figures/figure_parts.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr int largest_magnification = 16;

struct CellSize {
  int width = 0;
  int height = 0;
};

int heading_width(const FigureSizes& sizes) { return 11 * sizes.text; }

void check(const CloseupFigure& figure) {
  require_some(figure.columns.size(), "columns");
  require_some(figure.rows.size(), "rows");
  if (figure.magnification < 1 || figure.magnification > largest_magnification) {
    throw InputError(fmt::format("magnification {} of closeups: accepted: 1 to {}",
                                 figure.magnification, largest_magnification));
  }
  require_display(figure.overview, "overview", figure.overview);
  for (const CloseupFigureRow& row : figure.rows) {
    require_inside(row.rectangle, row.label, figure.overview);
    if (row.images.size() != figure.columns.size()) {
      throw InputError(fmt::format("closeups '{}': {} images for {} columns", row.label,
                                   row.images.size(), figure.columns.size()));
    }
    for (std::size_t i = 0; i < row.images.size(); ++i) {
      require_display(row.images[i], figure.columns[i].label, figure.overview);
    }
  }
}

CellSize cell_size(const CloseupFigure& figure) {
  CellSize cell;
  for (const CloseupFigureRow& row : figure.rows) {
    cell.width = std::max(cell.width, row.rectangle.width * figure.magnification);
    cell.height = std::max(cell.height, row.rectangle.height * figure.magnification);
  }
  return cell;
}

int magnification_in(const CellSize& cell, const Rectangle& rectangle) {
  return std::min(cell.width / rectangle.width, cell.height / rectangle.height);
}

Image row_heading(const CloseupFigureRow& row, int number, int magnification,
                  const FigureSizes& sizes) {
  const int width = heading_width(sizes);
  const std::string size = fmt::format("{}\u00d7{} pixels,\nenlarged {}\u00d7", row.rectangle.width,
                                       row.rectangle.height, magnification);
  const Image text =
      stack({text_block(row.label, {sizes.text, Weight::bold}, width),
             text_block(row.note, {sizes.text}, width), text_block(size, {sizes.text}, width)},
            0);
  const Image heading = stack({number_badge(number, sizes.title), text}, sizes.gap / 3);
  Image column = blank(width, heading.height());
  paste(column, 0, 0, heading);
  return column;
}

/// The names of the numbered rectangles, for those who look at the overview first.
Image key(const CloseupFigure& figure, int width, const FigureSizes& sizes) {
  std::vector<Image> entries;
  int number = 0;
  for (const CloseupFigureRow& row : figure.rows) {
    const Image badge = number_badge(++number, sizes.text);
    const std::string text = row.note.empty() ? row.label : row.label + " (" + row.note + ")";
    const int text_room = width - badge.width() - sizes.gap / 2;
    entries.push_back(beside({badge, text_block(text, {sizes.text}, text_room)}, sizes.gap / 2,
                             Placement::centre));
  }
  return stack(entries, sizes.gap / 3);
}

Image closeup_table(const CloseupFigure& figure, const CellSize& cell, const FigureSizes& sizes) {
  const int framed_width = cell.width + 2 * sizes.border;
  std::vector<Image> tabs = {blank(heading_width(sizes), 1)};
  int tab_height = 0;
  for (const CloseupColumn& column : figure.columns) {
    tabs.push_back(label_tab(column.label, column.colour, sizes, framed_width));
    tab_height = std::max(tab_height, tabs.back().height());
  }
  for (std::size_t i = 0; i < figure.columns.size(); ++i) {
    tabs[i + 1] = centred(tabs[i + 1], framed_width, tab_height, figure.columns[i].colour);
  }

  std::vector<Image> rows = {beside(tabs, sizes.gap / 2)};
  int number = 0;
  for (const CloseupFigureRow& row : figure.rows) {
    const int magnification = magnification_in(cell, row.rectangle);
    std::vector<Image> blocks = {row_heading(row, ++number, magnification, sizes)};
    for (std::size_t i = 0; i < row.images.size(); ++i) {
      const Image closeup = crop(row.images[i], row.rectangle, magnification);
      blocks.push_back(framed(centred(closeup, cell.width, cell.height), sizes.border,
                              figure.columns[i].colour));
    }
    rows.push_back(beside(blocks, sizes.gap / 2));
  }
  return stack(rows, sizes.gap / 2);
}

void outline(Image& image, const Rectangle& r, int distance, int thickness,
             const DisplayColour& colour) {
  const int outer = distance + thickness;
  const int left = r.x - outer;
  const int top = r.y - outer;
  const int width = r.width + 2 * outer;
  const int height = r.height + 2 * outer;
  fill(image, left, top, width, thickness, colour);
  fill(image, left, r.y + r.height + distance, width, thickness, colour);
  fill(image, left, top, thickness, height, colour);
  fill(image, r.x + r.width + distance, top, thickness, height, colour);
}

}  // namespace

Image crop(const Image& image, const Rectangle& rectangle, int magnification) {
  require_inside(rectangle, "closeup", image);
  if (magnification < 1) {
    throw InputError(fmt::format("magnification {}: accepted: 1 and more", magnification));
  }
  Image result(rectangle.width * magnification, rectangle.height * magnification, image.channels());
  for (int y = 0; y < result.height(); ++y) {
    for (int x = 0; x < result.width(); ++x) {
      const auto source =
          image.pixel(rectangle.x + x / magnification, rectangle.y + y / magnification);
      std::ranges::copy(source, result.pixel(x, y).begin());
    }
  }
  return result;
}

Image draw_rectangles(const Image& image, const std::vector<Rectangle>& rectangles) {
  require_display(image, "overview", image);
  Image result = image;
  const int thickness = std::max(1, image.width() / 640);
  const int text_size = std::max(16, image.width() / 56);
  int number = 0;
  for (const Rectangle& r : rectangles) {
    require_inside(r, fmt::format("{}", ++number), image);
    outline(result, r, 0, thickness, ink);
    outline(result, r, thickness, thickness, paper);
    outline(result, r, 2 * thickness, thickness, ink);
  }
  number = 0;
  for (const Rectangle& r : rectangles) {
    const Image badge = number_badge(++number, text_size);
    if (badge.width() > image.width() || badge.height() > image.height()) continue;
    const int above = r.y - 3 * thickness - badge.height();
    const int below = r.y + r.height + 3 * thickness;
    const int y = above >= 0 ? above : std::min(below, image.height() - badge.height());
    const int x = std::clamp(r.x - 3 * thickness, 0, image.width() - badge.width());
    paste(result, x, y, badge);
  }
  return result;
}

Image closeup_figure(const CloseupFigure& figure) {
  check(figure);
  const CellSize cell = cell_size(figure);
  const auto columns = static_cast<int>(figure.columns.size());
  const FigureSizes sizes(std::max(columns * cell.width, figure.overview.width()));
  const Image table = closeup_table(figure, cell, sizes);

  std::vector<Rectangle> rectangles;
  for (const CloseupFigureRow& row : figure.rows) rectangles.push_back(row.rectangle);
  const Image overview = framed(draw_rectangles(figure.overview, rectangles), 1, ink);

  // Key and caption fill the room beside the overview where that is wide enough to read.
  const int room = table.width() - overview.width() - 2 * sizes.gap;
  if (room < 18 * sizes.text) {
    return page(figure.title, {overview, table}, figure.caption, sizes);
  }
  const Image caption = text_block(figure.caption, {sizes.text}, room);
  const Image words = stack({key(figure, room, sizes), caption}, sizes.gap);
  return page(figure.title, {beside({overview, words}, 2 * sizes.gap), table}, "", sizes);
}

}  // namespace occlab
