#include "harness/table_layout.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>

#include "harness/experiment_tables.h"
#include "harness/table_formats.h"

namespace occlab {
namespace {

using Widths = std::vector<std::size_t>;

/// The parts between spaces; an interval is one, and so is a dash with its footnote.
std::vector<std::string> words(std::string_view text) {
  std::vector<std::string> parts;
  bool fresh = true;
  int depth = 0;
  for (const char c : text) {
    if (c == '[') ++depth;
    if (c == ']') --depth;
    const bool dash = !fresh && parts.back() == "–";
    if (c == ' ' && depth <= 0 && !dash) {
      fresh = true;
      continue;
    }
    if (fresh) parts.emplace_back();
    fresh = false;
    parts.back() += c;
  }
  return parts;
}

/// Words in lines of at most `width`; a word that is longer has a line of its own.
std::vector<std::string> broken(std::string_view text, std::size_t width) {
  if (text_width(text) <= width) return {std::string(text)};
  std::vector<std::string> lines;
  for (const std::string& word : words(text)) {
    if (lines.empty() || text_width(lines.back()) + 1 + text_width(word) > width) {
      lines.push_back(word);
    } else {
      lines.back() += ' ' + word;
    }
  }
  return lines;
}

/// A text whose further lines are indented.
std::string paragraph(std::string_view text, std::size_t columns, std::size_t indent) {
  std::string result;
  for (const std::string& line : broken(text, columns > indent ? columns - indent : 1)) {
    result += fmt::format("{}{}\n", result.empty() ? "" : std::string(indent, ' '), line);
  }
  return result;
}

std::size_t longest_word(std::string_view text) {
  std::size_t longest = 0;
  for (const std::string& word : words(text)) longest = std::max(longest, text_width(word));
  return longest;
}

/// Of each column: the width of its widest cell, as `measure` has it.
template <typename Measure>
Widths widest(const SpelledTable& table, Measure&& measure) {
  Widths widths(table.right.size(), 3);
  for (const auto& line : table.lines) {
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], measure(line[c]));
  }
  return widths;
}

std::size_t total_width(const Widths& widths) {
  return std::accumulate(widths.begin(), widths.end(), std::size_t(1),
                         [](std::size_t sum, std::size_t width) { return sum + width + 3; });
}

/// Takes from the widest columns until all fit, none below its least.
Widths narrowed(Widths widths, const Widths& least, std::size_t columns) {
  while (total_width(widths) > columns) {
    std::size_t best = widths.size();
    for (std::size_t c = 0; c < widths.size(); ++c) {
      if (widths[c] > least[c] && (best == widths.size() || widths[c] > widths[best])) best = c;
    }
    if (best == widths.size()) return widths;
    --widths[best];
  }
  return widths;
}

std::string padded(const std::string& text, std::size_t width, bool right) {
  const std::string padding(width - std::min(width, text_width(text)), ' ');
  return right ? padding + text : text + padding;
}

std::string rows_of(const SpelledTable& table, const Widths& widths) {
  std::string text;
  for (std::size_t i = 0; i < table.lines.size(); ++i) {
    std::vector<std::vector<std::string>> cells;
    std::size_t height = 1;
    for (std::size_t c = 0; c < widths.size(); ++c) {
      cells.push_back(broken(table.lines[i][c], widths[c]));
      height = std::max(height, cells.back().size());
    }
    for (std::size_t part = 0; part < height; ++part) {
      for (std::size_t c = 0; c < widths.size(); ++c) {
        const std::string cell = part < cells[c].size() ? cells[c][part] : "";
        text += fmt::format("| {} ", padded(cell, widths[c], table.right[c]));
      }
      text += "|\n";
    }
    if (i > 0) continue;
    for (std::size_t c = 0; c < widths.size(); ++c) {
      text += fmt::format("| {}{} ", std::string(widths[c] - 1, '-'), table.right[c] ? ':' : '-');
    }
    text += "|\n";
  }
  return text;
}

SpelledTable with_columns(const SpelledTable& table, const std::vector<std::size_t>& chosen) {
  SpelledTable part;
  for (const std::size_t c : chosen) part.right.push_back(table.right[c]);
  for (const auto& line : table.lines) {
    part.lines.emplace_back();
    for (const std::size_t c : chosen) part.lines.back().push_back(line[c]);
  }
  return part;
}

std::string fitted(const SpelledTable& table, std::size_t columns) {
  return rows_of(table, narrowed(widest(table, text_width), widest(table, longest_word), columns));
}

using Blocks = std::vector<std::vector<std::size_t>>;

/// The columns of each block, the first `count` in all; empty where one does not fit beside these.
Blocks blocks_of(const Widths& least, std::size_t count, std::size_t columns) {
  std::vector<std::size_t> keys(count);
  std::iota(keys.begin(), keys.end(), std::size_t(0));
  const Widths key_widths(least.begin(), least.begin() + std::ptrdiff_t(count));
  Blocks blocks;
  std::size_t used = 0;
  for (std::size_t c = count; c < least.size(); ++c) {
    if (blocks.empty() || used + least[c] + 3 > columns) {
      blocks.push_back(keys);
      used = total_width(key_widths);
    }
    used += least[c] + 3;
    if (used > columns) return {};
    blocks.back().push_back(c);
  }
  return blocks;
}

/// Each row as a list: the last resort.
std::string records(const SpelledTable& table, std::size_t columns) {
  std::string text;
  for (std::size_t i = 1; i < table.lines.size(); ++i) {
    for (std::size_t c = 0; c < table.right.size(); ++c) {
      const std::string cell = fmt::format("{}: {}", table.lines[0][c], table.lines[i][c]);
      text +=
          (c == 0 ? "- " : "  ") + paragraph(cell, columns - std::min<std::size_t>(columns, 2), 2);
    }
  }
  return text;
}

std::string body(const SpelledTable& table, std::size_t columns) {
  const Widths least = widest(table, longest_word);
  if (total_width(least) <= columns) return fitted(table, columns);
  Blocks blocks;
  for (std::size_t keys = table.keys; keys > 0 && blocks.empty(); --keys) {
    blocks = blocks_of(least, keys, columns);
  }
  if (blocks.empty()) return records(table, columns);
  std::string text;
  for (const auto& block : blocks) {
    if (!text.empty()) text += '\n';
    text += fitted(with_columns(table, block), columns);
  }
  return text;
}

}  // namespace

std::size_t text_width(std::string_view text) {
  return std::size_t(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string lay_out(const SpelledTable& table) {
  std::string text =
      fmt::format("## {}\n\n{}", table.title, rows_of(table, widest(table, text_width)));
  if (!table.notes.empty()) text += '\n';
  for (const std::string& note : table.notes) text += fmt::format("- {}\n", note);
  return text;
}

std::string lay_out(const SpelledTable& table, std::size_t columns) {
  std::string text = paragraph("## " + table.title, columns, 3) + '\n' + body(table, columns);
  if (!table.notes.empty()) text += '\n';
  for (const std::string& note : table.notes) text += paragraph("- " + note, columns, 2);
  return text;
}

std::optional<std::size_t> terminal_columns() {
  if (::isatty(STDOUT_FILENO) == 0) return std::nullopt;
  if (const char* stated = std::getenv("COLUMNS")) {
    char* end = nullptr;
    const long columns = std::strtol(stated, &end, 10);
    if (end != stated && *end == '\0' && columns > 0) return std::size_t(columns);
  }
  winsize size{};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return std::nullopt;
  return size.ws_col;
}

void print_tables(const std::vector<Table>& tables, const std::string& format) {
  const auto columns = format == "md" ? terminal_columns() : std::nullopt;
  if (!columns) {
    fmt::print("{}", format_tables(tables, format));
    return;
  }
  for (std::size_t i = 0; i < tables.size(); ++i) {
    fmt::print("{}{}", i > 0 ? "\n" : "", lay_out(spell_markdown(tables[i]), *columns));
  }
}

void print_table(const Table& table, const std::string& format) {
  if (format == "md") return print_tables({table}, format);
  fmt::print("{}", format_table(table, format));
}

}  // namespace occlab
