#include "harness/figures/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <ft2build.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <vector>

#include "renderers/scene/error.h"
#include FT_FREETYPE_H

// FreeType itself and not OpenImageIO's render_text: that one, as of 2.4, keeps only the last byte
// of a character outside of ASCII, so that a minus sign or a German title comes out wrong.

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

/// UTF-8 to code points; U+FFFD for each byte that is not part of a well-formed character.
std::vector<FT_ULong> code_points(std::string_view text) {
  constexpr FT_ULong replacement = 0xfffd;
  constexpr std::array<FT_ULong, 5> least = {0, 0, 0x80, 0x800, 0x10000};
  std::vector<FT_ULong> points;
  while (!text.empty()) {
    const auto lead = static_cast<unsigned char>(text.front());
    std::size_t length = 1;
    if (lead >= 0xc2 && lead < 0xe0) length = 2;
    if (lead >= 0xe0 && lead < 0xf0) length = 3;
    if (lead >= 0xf0 && lead < 0xf5) length = 4;
    FT_ULong point = length == 1 ? lead : FT_ULong(lead & (0xff >> (length + 1)));
    bool well_formed = lead < 0x80 || length > 1;
    for (std::size_t i = 1; i < length && well_formed; ++i) {
      well_formed = i < text.size() && (static_cast<unsigned char>(text[i]) & 0xc0) == 0x80;
      if (well_formed) point = point << 6 | (static_cast<unsigned char>(text[i]) & 0x3f);
    }
    well_formed = well_formed && (length == 1 || point >= least[length]);
    points.push_back(well_formed ? point : replacement);
    text.remove_prefix(well_formed ? length : 1);
  }
  return points;
}

class Font {
 public:
  explicit Font(const TextStyle& style) : style_(style) {
    const std::string file = font_file(style.weight);
    check(FT_Init_FreeType(&library_), file);
    FT_Error error = FT_New_Face(library_, file.c_str(), 0, &face_);
    if (error == 0) error = FT_Set_Pixel_Sizes(face_, 0, static_cast<FT_UInt>(style.size));
    if (error != 0) {
      FT_Done_FreeType(library_);
      check(error, file);
    }
  }
  ~Font() { FT_Done_FreeType(library_); }  // and its face
  Font(const Font&) = delete;
  Font& operator=(const Font&) = delete;

  /// Sets a line with its pen starting at x on the baseline y, or only measures it if there is no
  /// target; returns the right edge.
  int set_line(std::string_view line, Image* target, int x, int y) const {
    FT_Pos pen = FT_Pos(x) * 64;
    int right = x;
    FT_UInt previous = 0;
    for (const FT_ULong point : code_points(line)) {
      const FT_UInt glyph = FT_Get_Char_Index(face_, point);
      FT_Vector kerning{0, 0};
      if (previous != 0) FT_Get_Kerning(face_, previous, glyph, FT_KERNING_DEFAULT, &kerning);
      pen += kerning.x;
      const FT_Int32 flags = FT_LOAD_TARGET_LIGHT | (target ? FT_LOAD_RENDER : FT_LOAD_DEFAULT);
      check(FT_Load_Glyph(face_, glyph, flags), "a glyph");
      const FT_Pos origin = (pen + 32) / 64;
      if (target) blend(*target, static_cast<int>(origin), y);
      pen += face_->glyph->advance.x;
      right = std::max(right, static_cast<int>((pen + 63) / 64));
      previous = glyph;
    }
    return right;
  }

  int width(std::string_view line) const { return set_line(line, nullptr, 0, 0); }

 private:
  static void check(FT_Error error, std::string_view subject) {
    if (error == 0) return;
    throw DeviceError(
        fmt::format("FreeType cannot load {} for the text of figures: error {}", subject, error));
  }

  void blend(Image& target, int origin, int baseline) const {
    const FT_GlyphSlot slot = face_->glyph;
    const auto rows = static_cast<int>(slot->bitmap.rows);
    const auto columns = static_cast<int>(slot->bitmap.width);
    for (int row = 0; row < rows; ++row) {
      const int y = baseline - slot->bitmap_top + row;
      if (y < 0 || y >= target.height()) continue;
      for (int column = 0; column < columns; ++column) {
        const int x = origin + slot->bitmap_left + column;
        if (x < 0 || x >= target.width()) continue;
        const auto coverage =
            static_cast<float>(slot->bitmap.buffer[row * slot->bitmap.pitch + column]) / 255.0f;
        for (int c = 0; c < 3; ++c) {
          float& value = target.at(x, y, c);
          value = std::lerp(value, style_.colour[std::size_t(c)], coverage);
        }
      }
    }
  }

  TextStyle style_;
  FT_Library library_ = nullptr;
  FT_Face face_ = nullptr;
};

bool continues_code_point(char byte) { return (static_cast<unsigned char>(byte) & 0xc0) == 0x80; }

/// The longest start of a word that fits, at least one code point.
std::size_t fitting_prefix(std::string_view word, const Font& font, int width) {
  std::size_t fits = 0;
  for (std::size_t end = 1; end <= word.size(); ++end) {
    if (end < word.size() && continues_code_point(word[end])) continue;
    if (fits > 0 && font.width(word.substr(0, end)) > width) break;
    fits = end;
  }
  return fits;
}

void append_wrapped(std::vector<std::string>& lines, std::string_view paragraph, const Font& font,
                    int width) {
  std::string line;
  while (!paragraph.empty()) {
    const std::size_t space = paragraph.find(' ');
    std::string word(paragraph.substr(0, space));
    paragraph.remove_prefix(space == std::string_view::npos ? paragraph.size() : space + 1);
    const std::string extended = line.empty() ? word : line + ' ' + word;
    if (font.width(extended) <= width) {
      line = extended;
      continue;
    }
    if (!line.empty()) lines.push_back(line);
    while (font.width(word) > width) {
      const std::size_t fits = fitting_prefix(word, font, width);
      if (fits == word.size()) break;
      lines.push_back(word.substr(0, fits));
      word.erase(0, fits);
    }
    line = word;
  }
  lines.push_back(line);
}

std::vector<std::string> wrap(std::string_view text, const Font& font, int width) {
  std::vector<std::string> lines;
  while (true) {
    const std::size_t end = text.find('\n');
    append_wrapped(lines, text.substr(0, end), font, width);
    if (end == std::string_view::npos) return lines;
    text.remove_prefix(end + 1);
  }
}

}  // namespace

int text_width(const std::string& line, const TextStyle& style) { return Font(style).width(line); }

Image text_block(const std::string& text, const TextStyle& style, int width) {
  if (text.empty()) return {};
  const Font font(style);
  const std::vector<std::string> lines = wrap(text, font, width);
  int widest = 1;
  for (const std::string& line : lines) widest = std::max(widest, font.width(line));
  const double line_height = line_height_em * style.size;
  const auto lines_height = static_cast<int>(std::ceil(line_height * double(lines.size())));
  Image block = blank(widest, lines_height, style.background);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double baseline =
        line_height * double(i) + 0.5 * (line_height + capital_height_em * style.size);
    font.set_line(lines[i], &block, 0, static_cast<int>(std::lround(baseline)));
  }
  return block;
}

}  // namespace occlab
