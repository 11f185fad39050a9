#pragma once

#include <string>

#include "harness/figures/canvas.h"

namespace occlab {

enum class Weight { regular, bold };

struct TextStyle {
  int size = 16;  ///< pixels an em
  Weight weight = Weight::regular;
  DisplayColour colour = ink;
  DisplayColour background = paper;
};

// Text is UTF-8; a byte that is not shows as U+FFFD, a character that the font lacks as a box. Both
// functions throw DeviceError without the font.

/// Pixels from the start of a line to its end.
int text_width(const std::string& line, const TextStyle& style);

/// The text in lines of at most `width` pixels, broken at spaces and '\n' (within a word where the
/// word alone is wider); as wide as its widest line. An empty text is an empty image.
Image text_block(const std::string& text, const TextStyle& style, int width);

}  // namespace occlab
