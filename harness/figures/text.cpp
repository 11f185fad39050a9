#include "harness/figures/text.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <vector>

#include "renderers/scene/error.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

// Where Debian, Fedora, Arch and Alpine keep the DejaVu fonts.
constexpr std::array<std::string_view, 5> font_folders = {
    "/usr/share/fonts/truetype/dejavu", "/usr/share/fonts/dejavu-sans-fonts",
    "/usr/share/fonts/dejavu", "/usr/share/fonts/TTF", "/usr/local/share/fonts/dejavu"};

constexpr double line_height_em = 1.36;
constexpr double capital_height_em = 0.73;  // of DejaVu Sans

std::string font_file(Weight weight) {
  const char* name = weight == Weight::bold ? "DejaVuSans-Bold.ttf" : "DejaVuSans.ttf";
  for (const std::string_view folder : font_folders) {
    const fs::path path = fs::path(folder) / name;
    std::error_code ignored;
    if (fs::exists(path, ignored)) return path.string();
  }
  throw DeviceError(
      fmt::format("the font {} for the text of figures is in none of {}; on Debian: apt-get "
                  "install fonts-dejavu-core",
                  name, fmt::join(font_folders, ", ")));
}

OIIO::ROI measure(const std::string& line, const TextStyle& style) {
  const std::string font = font_file(style.weight);
  const OIIO::ROI extent = OIIO::ImageBufAlgo::text_size(line, style.size, font);
  if (!extent.defined()) {
    throw DeviceError(fmt::format(
        "OpenImageIO cannot measure text in {}: it was built without FreeType, or the font is "
        "damaged",
        font));
  }
  return extent;
}

bool continues_code_point(char byte) { return (static_cast<unsigned char>(byte) & 0xc0) == 0x80; }

/// The longest start of a word that fits, at least one code point.
std::size_t fitting_prefix(const std::string& word, const TextStyle& style, int width) {
  std::size_t fits = 0;
  for (std::size_t end = 1; end <= word.size(); ++end) {
    if (end < word.size() && continues_code_point(word[end])) continue;
    if (fits > 0 && text_width(word.substr(0, end), style) > width) break;
    fits = end;
  }
  return fits;
}

void append_wrapped(std::vector<std::string>& lines, std::string_view paragraph,
                    const TextStyle& style, int width) {
  std::string line;
  while (!paragraph.empty()) {
    const std::size_t space = paragraph.find(' ');
    std::string word(paragraph.substr(0, space));
    paragraph.remove_prefix(space == std::string_view::npos ? paragraph.size() : space + 1);
    const std::string extended = line.empty() ? word : line + ' ' + word;
    if (text_width(extended, style) <= width) {
      line = extended;
      continue;
    }
    if (!line.empty()) lines.push_back(line);
    while (text_width(word, style) > width) {
      const std::size_t fits = fitting_prefix(word, style, width);
      if (fits == word.size()) break;
      lines.push_back(word.substr(0, fits));
      word.erase(0, fits);
    }
    line = word;
  }
  lines.push_back(line);
}

std::vector<std::string> wrap(std::string_view text, const TextStyle& style, int width) {
  std::vector<std::string> lines;
  while (true) {
    const std::size_t end = text.find('\n');
    append_wrapped(lines, text.substr(0, end), style, width);
    if (end == std::string_view::npos) return lines;
    text.remove_prefix(end + 1);
  }
}

}  // namespace

int text_width(const std::string& line, const TextStyle& style) {
  return std::max(0, measure(line, style).xend);
}

Image text_block(const std::string& text, const TextStyle& style, int width) {
  if (text.empty()) return {};
  const std::vector<std::string> lines = wrap(text, style, width);
  int widest = 1;
  for (const std::string& line : lines) widest = std::max(widest, text_width(line, style));
  const double line_height = line_height_em * style.size;
  const auto lines_height = static_cast<int>(std::ceil(line_height * double(lines.size())));
  Image block = blank(widest, lines_height, style.background);

  OIIO::ImageBuf target(OIIO::ImageSpec(block.width(), block.height(), 3, OIIO::TypeFloat),
                        block.values().data());
  const std::string font = font_file(style.weight);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].empty()) continue;
    const double top = line_height * double(i);
    const auto baseline =
        static_cast<int>(std::lround(top + 0.5 * (line_height + capital_height_em * style.size)));
    if (!OIIO::ImageBufAlgo::render_text(target, 0, baseline, lines[i], style.size, font,
                                         style.colour)) {
      throw DeviceError(fmt::format("OpenImageIO cannot draw text: {}", target.geterror()));
    }
  }
  return block;
}

}  // namespace occlab
