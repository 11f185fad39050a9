#include "harness/table_formats.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cctype>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "harness/csv.h"
#include "harness/table_layout.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

using Json = nlohmann::ordered_json;

/// How a format spells the pieces of a cell.
struct Spelling {
  std::function<std::string(std::string_view)> text;
  std::function<std::string(const TableNumber&)> number;
  std::function<std::string(std::size_t)> missing;  ///< from the number of the footnote
};

/// "1.057", {"1.052", "1.061"}: a number and its interval, rounded alike.
struct RoundedNumber {
  std::string value, lower, upper;  ///< lower and upper are empty without an interval
};

RoundedNumber round_number(const TableNumber& number) {
  assert(number.lower.has_value() == number.upper.has_value());
  const auto four_digits = [](double value) { return fmt::format("{:.4g}", value); };
  if (!number.lower) return {four_digits(number.value), "", ""};
  const double half_width = 0.5 * (*number.upper - *number.lower);
  if (!(half_width > 0) || std::isinf(half_width) || std::isinf(number.value)) {
    return {four_digits(number.value), four_digits(*number.lower), four_digits(*number.upper)};
  }
  const double exponent = std::floor(std::log10(half_width));
  const double largest =
      std::max({std::abs(number.value), std::abs(*number.lower), std::abs(*number.upper)});
  if (largest < 1e-4 || largest >= 1e7) {
    const int digits = std::clamp(int(std::floor(std::log10(largest)) - exponent) + 1, 0, 16);
    const auto scientific = [&](double value) { return fmt::format("{:.{}e}", value, digits); };
    return {scientific(number.value), scientific(*number.lower), scientific(*number.upper)};
  }
  const int decimals = std::clamp(1 - int(exponent), 0, 16);
  const auto fixed = [&](double value) { return fmt::format("{:.{}f}", value, decimals); };
  return {fixed(number.value), fixed(*number.lower), fixed(*number.upper)};
}

/// The texts of all rows; `footnotes` collects the reasons of missing numbers.
std::vector<std::vector<std::string>> spell_rows(const Table& table, const Spelling& spelling,
                                                 std::vector<std::string>& footnotes) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& row : table.rows) {
    assert(row.size() == table.columns.size());
    rows.emplace_back();
    for (const TableCell& cell : row) {
      if (const auto* text = std::get_if<std::string>(&cell)) {
        rows.back().push_back(spelling.text(*text));
      } else if (const auto* number = std::get_if<TableNumber>(&cell)) {
        rows.back().push_back(spelling.number(*number));
      } else {
        const std::string& reason = std::get<TableMissing>(cell).reason;
        auto note = std::ranges::find(footnotes, reason);
        if (note == footnotes.end()) note = footnotes.insert(note, reason);
        rows.back().push_back(spelling.missing(std::size_t(note - footnotes.begin()) + 1));
      }
    }
  }
  return rows;
}

std::string column_title(const TableColumn& column) {
  return column.unit.empty() ? column.name : fmt::format("{} ({})", column.name, column.unit);
}

std::string escape_markdown(std::string_view text) {
  std::string escaped;
  const auto is_word = [&](std::size_t i) {
    return i < text.size() && std::isalnum(static_cast<unsigned char>(text[i])) != 0;
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    // An underscore inside a word is no emphasis (CommonMark 6.2) and stays readable.
    const bool inner_underscore = text[i] == '_' && i > 0 && is_word(i - 1) && is_word(i + 1);
    if (text[i] == '\n' || text[i] == '\r') {
      escaped += ' ';
      continue;
    }
    if (std::string_view("\\|*`<&[]_~").find(text[i]) != std::string_view::npos &&
        !inner_underscore) {
      escaped += '\\';
    }
    escaped += text[i];
  }
  return escaped;
}

std::string markdown(const Table& table) { return lay_out(spell_markdown(table)); }

std::string latex(const Table& table) {
  const auto in_math = [](const std::string& number) {
    return number == "inf" ? "\\infty" : number == "-inf" ? "-\\infty" : number;
  };
  const Spelling spelling{
      escape_latex,
      [&](const TableNumber& number) {
        const RoundedNumber rounded = round_number(number);
        std::string value = fmt::format("${}$", in_math(rounded.value));
        if (number.winner) value = fmt::format("\\textbf{{\\boldmath{}}}", value);
        return rounded.lower.empty() ? value
                                     : fmt::format("{} {{\\footnotesize $[{}, {}]$}}", value,
                                                   in_math(rounded.lower), in_math(rounded.upper));
      },
      [](std::size_t note) { return fmt::format("--\\textsuperscript{{{}}}", note); }};
  std::vector<std::string> footnotes;
  const std::vector<std::vector<std::string>> rows = spell_rows(table, spelling, footnotes);

  std::string alignments;
  std::vector<std::string> titles;
  for (const TableColumn& column : table.columns) {
    alignments += column.alignment == Alignment::right ? 'r' : 'l';
    titles.push_back(escape_latex(column_title(column)));
  }
  std::string text = fmt::format(
      "% needs \\usepackage{{booktabs}}\n\\begin{{table}}\n\\centering\n\\caption{{{}}}\n"
      "\\label{{tab:{}}}\n\\begin{{tabular}}{{{}}}\n\\toprule\n{} \\\\\n\\midrule\n",
      escape_latex(table.title), table.name, alignments, fmt::join(titles, " & "));
  for (const auto& row : rows) text += fmt::format("{} \\\\\n", fmt::join(row, " & "));
  text += "\\bottomrule\n\\end{tabular}\n";
  for (std::size_t i = 0; i < footnotes.size(); ++i) {
    text += fmt::format("\\par{{\\footnotesize\\textsuperscript{{{}}}{}}}\n", i + 1,
                        escape_latex(footnotes[i]));
  }
  for (const std::string& note : table.notes) {
    text += fmt::format("\\par{{\\footnotesize {}}}\n", escape_latex(note));
  }
  return text + "\\end{table}\n";
}

std::string csv(const Table& table) {
  // A column of numbers has as many fields as its richest cell.
  struct Fields {
    bool interval = false;
    bool winner = false;
    bool missing = false;
  };
  std::vector<Fields> fields(table.columns.size());
  for (const auto& row : table.rows) {
    assert(row.size() == table.columns.size());
    for (std::size_t c = 0; c < row.size(); ++c) {
      const auto* number = std::get_if<TableNumber>(&row[c]);
      fields[c].interval |= number && number->lower;
      fields[c].winner |= number && number->winner;
      fields[c].missing |= std::holds_alternative<TableMissing>(row[c]);
    }
  }
  std::vector<std::string> header;
  for (std::size_t c = 0; c < fields.size(); ++c) {
    const std::string title = column_title(table.columns[c]);
    header.push_back(title);
    if (fields[c].interval) header.insert(header.end(), {title + " lower", title + " upper"});
    if (fields[c].winner) header.push_back(title + " winner");
    if (fields[c].missing) header.push_back(title + " missing");
  }
  std::string text = csv_line(header);
  for (const auto& row : table.rows) {
    std::vector<std::string> line;
    for (std::size_t c = 0; c < row.size(); ++c) {
      const auto* words = std::get_if<std::string>(&row[c]);
      const auto* number = std::get_if<TableNumber>(&row[c]);
      const auto* missing = std::get_if<TableMissing>(&row[c]);
      line.push_back(words ? *words : number ? number_text(number->value) : "");
      if (fields[c].interval) {
        line.push_back(number && number->lower ? number_text(*number->lower) : "");
        line.push_back(number && number->upper ? number_text(*number->upper) : "");
      }
      if (fields[c].winner) line.emplace_back(number && number->winner ? "yes" : "");
      if (fields[c].missing) line.push_back(missing ? missing->reason : "");
    }
    text += csv_line(line);
  }
  return text;
}

/// JSON has no infinity.
Json json_number(double value) {
  return std::isinf(value) ? Json(number_text(value)) : Json(value);
}

std::string json(const Table& table) {
  Json result;
  result["name"] = table.name;
  result["title"] = table.title;
  result["columns"] = Json::array();
  for (const TableColumn& column : table.columns) {
    result["columns"].push_back({{"name", column.name}, {"unit", column.unit}});
  }
  result["rows"] = Json::array();
  for (const auto& row : table.rows) {
    Json cells = Json::array();
    for (const TableCell& cell : row) {
      if (const auto* text = std::get_if<std::string>(&cell)) {
        cells.push_back(*text);
      } else if (const auto* number = std::get_if<TableNumber>(&cell)) {
        Json entry;
        entry["value"] = json_number(number->value);
        if (number->lower) entry["lower"] = json_number(*number->lower);
        if (number->upper) entry["upper"] = json_number(*number->upper);
        if (number->winner) entry["winner"] = true;
        cells.push_back(std::move(entry));
      } else {
        cells.push_back(Json{{"missing", std::get<TableMissing>(cell).reason}});
      }
    }
    result["rows"].push_back(std::move(cells));
  }
  result["notes"] = table.notes;
  try {
    return result.dump(2) + "\n";
  } catch (const Json::exception& error) {
    throw InputError(
        fmt::format("table '{}' holds text that is not UTF-8: {}", table.name, error.what()));
  }
}

struct Format {
  std::string name;
  std::string extension;
  std::string (*write)(const Table&);
};
const std::array<Format, 4> formats = {{{"md", ".md", markdown},
                                        {"csv", ".csv", csv},
                                        {"json", ".json", json},
                                        {"latex", ".tex", latex}}};

const Format& find_format(const std::string& name) {
  const auto format = std::ranges::find(formats, name, &Format::name);
  if (format == formats.end()) {
    throw InputError(
        fmt::format("unknown table format '{}'{}", name, accepted_words(name, table_formats())));
  }
  return *format;
}

/// How many leading columns hold text alone; 1 where all do.
std::size_t text_columns(const Table& table) {
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    const auto is_text = [&](const auto& row) {
      return std::holds_alternative<std::string>(row[c]);
    };
    if (!std::ranges::all_of(table.rows, is_text)) return c;
  }
  return 1;
}

}  // namespace

SpelledTable spell_markdown(const Table& table) {
  const Spelling spelling{
      escape_markdown,
      [](const TableNumber& number) {
        const RoundedNumber rounded = round_number(number);
        const std::string value =
            number.winner ? fmt::format("**{}**", rounded.value) : rounded.value;
        return rounded.lower.empty()
                   ? value
                   : fmt::format("{} [{}, {}]", value, rounded.lower, rounded.upper);
      },
      [](std::size_t note) { return fmt::format("– ({})", note); }};
  SpelledTable spelled;
  spelled.title = escape_markdown(table.title);
  std::vector<std::string> footnotes;
  spelled.lines = spell_rows(table, spelling, footnotes);
  std::vector<std::string> titles;
  for (const TableColumn& column : table.columns) {
    titles.push_back(escape_markdown(column_title(column)));
    spelled.right.push_back(column.alignment == Alignment::right);
  }
  spelled.lines.insert(spelled.lines.begin(), std::move(titles));
  spelled.keys = text_columns(table);
  for (std::size_t i = 0; i < footnotes.size(); ++i) {
    spelled.notes.push_back(fmt::format("({}) {}", i + 1, escape_markdown(footnotes[i])));
  }
  for (const std::string& note : table.notes) spelled.notes.push_back(escape_markdown(note));
  return spelled;
}

const std::vector<std::string>& table_formats() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result;
    for (const Format& format : formats) result.push_back(format.name);
    return result;
  }();
  return names;
}

std::string format_table(const Table& table, const std::string& format) {
  return find_format(format).write(table);
}

std::string table_extension(const std::string& format) { return find_format(format).extension; }

std::string escape_latex(std::string_view text) {
  // '[' in braces: at the start of a row it would be the option of the row end before it.
  static const std::vector<std::pair<std::string_view, std::string_view>> replacements = {
      {"\\", "\\textbackslash{}"},
      {"{", "\\{"},
      {"}", "\\}"},
      {"&", "\\&"},
      {"%", "\\%"},
      {"$", "\\$"},
      {"#", "\\#"},
      {"_", "\\_"},
      {"~", "\\textasciitilde{}"},
      {"^", "\\textasciicircum{}"},
      {"<", "\\textless{}"},
      {">", "\\textgreater{}"},
      {"|", "\\textbar{}"},
      {"\"", "\\textquotedbl{}"},
      {"[", "{[}"},
      {"]", "{]}"},
      {"\n", " "},
      {"\r", " "},
      {"–", "--"},
      {"—", "---"},
      {"×", "$\\times$"},
      {"±", "$\\pm$"},
      {"∞", "$\\infty$"},
      {"≤", "$\\leq$"},
      {"≥", "$\\geq$"},
      {"°", "$^\\circ$"},
      {"µ", "$\\mu$"},
      {"≈", "$\\approx$"}};
  std::string escaped;
  while (!text.empty()) {
    const auto found = std::ranges::find_if(
        replacements, [&](const auto& entry) { return text.starts_with(entry.first); });
    if (found == replacements.end()) {
      escaped += text.front();
      text.remove_prefix(1);
    } else {
      escaped += found->second;
      text.remove_prefix(found->first.size());
    }
  }
  return escaped;
}

}  // namespace occlab
