#include "harness/figures/figure_parts.h"

#include <fmt/format.h>

#include <algorithm>

#include "harness/metrics/image_checks.h"
#include "renderers/scene/error.h"

namespace occlab {

FigureSizes::FigureSizes(int content_width)
    : text(std::max(16, content_width / 80)),
      title(text * 5 / 4),
      gap(text * 3 / 4),
      border(std::max(3, text / 5)) {}

Image label_tab(const std::string& label, const DisplayColour& colour, const FigureSizes& sizes,
                int width) {
  const int padding = sizes.title / 2;
  const TextStyle style{sizes.title, Weight::bold, paper, colour};
  const Image text = text_block(label, style, width > 0 ? width - 2 * padding : 40 * sizes.title);
  return centred(text, std::max(width, text.width() + 2 * padding), text.height() + padding / 2,
                 colour);
}

Image framed_panel(const std::string& label, const DisplayColour& colour, const Image& image,
                   const FigureSizes& sizes) {
  const Image framed_image = framed(image, sizes.border, colour);
  return stack({label_tab(label, colour, sizes), framed_image}, 0);
}

Image grid(const std::vector<Image>& blocks, int columns, int gap) {
  std::vector<Image> rows;
  for (std::size_t first = 0; first < blocks.size(); first += std::size_t(columns)) {
    const std::size_t last = std::min(blocks.size(), first + std::size_t(columns));
    rows.push_back(beside(
        {blocks.begin() + std::ptrdiff_t(first), blocks.begin() + std::ptrdiff_t(last)}, gap));
  }
  return stack(rows, gap);
}

Image page(const std::string& title, const std::vector<Image>& content, const std::string& caption,
           const FigureSizes& sizes) {
  int width = 0;
  for (const Image& block : content) width = std::max(width, block.width());
  std::vector<Image> blocks = {text_block(title, {sizes.title, Weight::bold}, width)};
  blocks.insert(blocks.end(), content.begin(), content.end());
  blocks.push_back(text_block(caption, {sizes.text}, width));
  return framed(stack(blocks, sizes.gap), 2 * sizes.gap, paper);
}

Image number_badge(int number, int text_size) {
  const Image digits =
      text_block(fmt::format("{}", number), {text_size, Weight::bold, paper, ink}, 10 * text_size);
  const int side = std::max(digits.height(), digits.width() + text_size / 2);
  return centred(digits, side, side, ink);
}

std::string number_text(double value, int digits) {
  std::string text = fmt::format("{:.{}g}", value, digits);
  if (text.front() == '-') text.replace(0, 1, "\u2212");
  return text;
}

std::string signed_number_text(double value, int digits) {
  return value > 0.0 ? fmt::format("+{}", number_text(value, digits)) : number_text(value, digits);
}

void require_display(const Image& image, std::string_view name, const Image& like) {
  require_shape(image, name, like, 3);
  if (image.empty()) throw InputError(fmt::format("{} image: it has no pixels", name));
  for (std::size_t i = 0; i < image.values().size(); ++i) {
    const float value = image.values()[i];
    if (value >= 0.0f && value <= 1.0f) continue;
    const auto width = static_cast<std::size_t>(image.width());
    throw InputError(
        fmt::format("{} image: pixel ({}, {}) holds {}; accepted: display-referred values from 0 "
                    "to 1",
                    name, i / 3 % width, i / 3 / width, value));
  }
}

void require_some(std::size_t count, std::string_view what) {
  if (count == 0)
    throw InputError(fmt::format("a figure without {}: at least one is needed", what));
}

void require_inside(const Rectangle& rectangle, std::string_view name, const Image& image) {
  const Rectangle& r = rectangle;
  const bool inside = r.x >= 0 && r.y >= 0 && r.width > 0 && r.height > 0 &&
                      r.width <= image.width() && r.x <= image.width() - r.width &&
                      r.height <= image.height() && r.y <= image.height() - r.height;
  if (inside) return;
  throw InputError(
      fmt::format("rectangle '{}': [x, y, width, height] = [{}, {}, {}, {}]; accepted: at least "
                  "one pixel, inside the frame of {}x{}",
                  name, r.x, r.y, r.width, r.height, image.width(), image.height()));
}

}  // namespace occlab
