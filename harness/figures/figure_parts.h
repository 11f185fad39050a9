#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "harness/figures/figures.h"
#include "harness/figures/text.h"

namespace occlab {

/// Sizes in pixels that follow from the width of a figure's content, so that a figure shown at the
/// width of a page has the same text size whatever its resolution.
struct FigureSizes {
  explicit FigureSizes(int content_width);
  int text;    ///< body text, at least 16
  int title;   ///< title and labels
  int gap;     ///< between blocks
  int border;  ///< thickness of frames
};

/// The colour-filled label that sits on a frame, as wide as its text or, where `width` > 0, that.
Image label_tab(const std::string& label, const DisplayColour& colour, const FigureSizes& sizes,
                int width = 0);

/// Label above, image in its frame of colour below.
Image framed_panel(const std::string& label, const DisplayColour& colour, const Image& image,
                   const FigureSizes& sizes);

/// Blocks in rows of `columns`, aligned at their tops.
Image grid(const std::vector<Image>& blocks, int columns, int gap);

/// Title above, content, caption below, on a white margin.
Image page(const std::string& title, const std::vector<Image>& content, const std::string& caption,
           const FigureSizes& sizes);

/// A number in an ink-coloured square.
Image number_badge(int number, int text_size);

/// A number for people: "−0.25" with a true minus sign.
std::string number_text(double value, int digits = 3);

/// The same with a plus sign before what is positive.
std::string signed_number_text(double value, int digits = 3);

/// InputError unless the image has three channels, all in [0, 1], and the size of `like`.
void require_display(const Image& image, std::string_view name, const Image& like);

/// InputError for an empty list.
void require_some(std::size_t count, std::string_view what);

/// InputError unless the rectangle is not empty and inside the image.
void require_inside(const Rectangle& rectangle, std::string_view name, const Image& image);

}  // namespace occlab
