#pragma once

#include <string>
#include <string_view>

#include "harness/tables.h"

namespace occlab {

/// The formats: md, csv, json, latex.
const std::vector<std::string>& table_formats();

/// Throws InputError for an unknown format. Markdown and LaTeX round to what the interval supports
/// (two digits of its half width; four significant digits without one) and print a missing number
/// as a dash with a footnote, a winner in bold; CSV (RFC 4180, NAME, NAME lower, NAME upper, NAME
/// winner, NAME missing, each of the last four where the column has any; a winner is "yes") and
/// JSON
/// ("winner": true) keep full precision; JSON writes infinity as the string "inf".
std::string format_table(const Table& table, const std::string& format);

/// "md" -> ".md", "latex" -> ".tex".
std::string table_extension(const std::string& format);

/// Text with LaTeX's ten special characters escaped and UTF-8 signs that pdflatex lacks replaced.
std::string escape_latex(std::string_view text);

}  // namespace occlab
