#include "harness/csv.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "renderers/scene/error.h"

namespace occlab {

std::vector<CsvRecord> parse_csv(std::string_view text, const std::string& name) {
  std::vector<CsvRecord> records;
  std::size_t i = 0;
  int line = 1;
  const auto fail = [&](int at, std::string_view what) {
    throw InputError(fmt::format("{}:{}: {}", name, at, what));
  };
  const auto at_line_end = [&] { return text[i] == '\n' || text.substr(i, 2) == "\r\n"; };
  while (i < text.size()) {
    CsvRecord record{line, {}};
    for (bool more = true; more;) {
      std::string field;
      if (i < text.size() && text[i] == '"') {
        const int opened = line;
        for (++i;; ++i) {
          if (i >= text.size()) fail(opened, "a quoted field is not closed");
          if (text[i] == '"' && text.substr(i, 2) != "\"\"") break;
          if (text[i] == '"') ++i;
          if (text[i] == '\n') ++line;
          field += text[i];
        }
        ++i;
      } else {
        while (i < text.size() && text[i] != ',' && !at_line_end()) {
          if (text[i] == '"' || text[i] == '\r') {
            fail(line, "a quote or carriage return inside a field that is not quoted");
          }
          field += text[i++];
        }
      }
      record.fields.push_back(std::move(field));
      more = i < text.size() && text[i] == ',';
      if (more) ++i;
    }
    if (i < text.size()) {
      if (!at_line_end()) fail(line, "text after a quoted field");
      i += text[i] == '\r' ? 2 : 1;
      ++line;
    }
    if (!records.empty() && record.fields.size() != records.front().fields.size()) {
      fail(record.line, fmt::format("{} fields; the first line has {}", record.fields.size(),
                                    records.front().fields.size()));
    }
    records.push_back(std::move(record));
  }
  return records;
}

std::string csv_line(const std::vector<std::string>& fields) {
  std::string line;
  for (const std::string& field : fields) {
    if (&field != &fields.front()) line += ',';
    if (field.find_first_of(",\"\r\n") == std::string::npos) {
      line += field;
      continue;
    }
    line += '"';
    for (const char c : field) line += c == '"' ? std::string("\"\"") : std::string(1, c);
    line += '"';
  }
  return line + "\r\n";
}

std::string number_text(double value) { return fmt::format("{}", value); }

double parse_number(std::string_view field, const std::string& where) {
  double value = 0;
  const char* const end = field.data() + field.size();
  const auto [rest, error] = std::from_chars(field.data(), end, value);
  if (error != std::errc() || rest != end || std::isnan(value)) {
    throw InputError(
        fmt::format("{}: found '{}'; accepted is a number, inf or -inf", where, field));
  }
  return value;
}

}  // namespace occlab
