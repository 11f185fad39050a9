#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "harness/tables.h"

namespace occlab {

/// A table in the words of Markdown, not yet laid out.
struct SpelledTable {
  std::string title;
  std::vector<std::vector<std::string>> lines;  ///< the columns' titles, then the rows
  std::vector<bool> right;                      ///< of each column: aligned to the right
  std::size_t keys = 0;                         ///< leading columns that say what a row is of
  std::vector<std::string> notes;
};

SpelledTable spell_markdown(const Table& table);

/// Characters of a UTF-8 text: its width in a terminal, near enough.
std::size_t text_width(std::string_view text);

/// One line for each row, however long.
std::string lay_out(const SpelledTable& table);

/// Lines of at most `columns` characters, for reading; nothing is left out, and neither a number,
/// an interval nor any other word is cut, but one that is longer than `columns` alone. What fits is
/// laid out as above. Else, in this order: cells are broken at spaces; the columns are dealt out to
/// several blocks of the same rows, each with as many of the leading columns that say what a row is
/// of as leave room for the others; and where a column does not fit beside the first, each row
/// becomes a list of its cells.
std::string lay_out(const SpelledTable& table, std::size_t columns);

/// The width of the terminal that standard output is: $COLUMNS where that is a number above 0, else
/// what the terminal says. Nothing where standard output is no terminal or does not know its width.
std::optional<std::size_t> terminal_columns();

/// Prints tables to standard output: Markdown to a terminal fits its width, everything else is as
/// format_tables() has it.
void print_tables(const std::vector<Table>& tables, const std::string& format);
void print_table(const Table& table, const std::string& format);  ///< as format_table() has it

}  // namespace occlab
