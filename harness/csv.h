#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace occlab {

/// One record of an RFC 4180 file and the line it starts on.
struct CsvRecord {
  int line = 0;
  std::vector<std::string> fields;
};

/// Splits RFC 4180 text: quoted fields may hold commas, line ends and doubled quotes. Throws
/// InputError "NAME:LINE: ..." for stray or unclosed quotes and for records whose number of fields
/// differs from the first one's.
std::vector<CsvRecord> parse_csv(std::string_view text, const std::string& name);

/// The record with its line end; fields are quoted where needed.
std::string csv_line(const std::vector<std::string>& fields);

/// The shortest text that reads back as the same double; "inf" and "-inf".
std::string number_text(double value);
/// The inverse; the whole field must be a number and not NaN. `where` begins the InputError.
double parse_number(std::string_view field, const std::string& where);

}  // namespace occlab
