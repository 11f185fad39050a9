#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace occlab {

// The small language of claims: `noise(ssdo, 32) > 2 * noise(s3ho, 32)`.
//
//   statement = side (">" | "<") side | side "~" side "within" number "%"
//             | side "in" "[" number "," number "]"
//   side      = factor { ("*" | "/") factor }
//   factor    = number | metric "(" method { "," argument } ")"
//   argument  = value, which is samples=value | name "=" value
//   value     = a word or number, or a text in single quotes
//
// A word of capitals is a variable, and is replaced by its value.

/// One measured quantity, such as noise(ssdo, 32).
struct ClaimTerm {
  std::string metric;  ///< as in measurements.csv: "noise", "time_ms.occlusion"
  std::string method;
  /// Which rows: columns and parameters by name, `closeup` a part of a view. In order of writing.
  std::vector<std::pair<std::string, std::string>> filters;

  /// nullptr if there is no such filter.
  const std::string* filter(std::string_view name) const;
  bool operator==(const ClaimTerm&) const = default;
};

/// "noise(ssdo, samples=32)", with the filters of `shown` only.
std::string to_string(const ClaimTerm& term, const std::set<std::string>& shown = {"samples"});

struct ClaimFactor {
  ClaimTerm term;
  int power = 1;  ///< 1 or -1
};

/// number * product of term^power.
struct ClaimQuantity {
  double number = 1.0;
  std::vector<ClaimFactor> factors;  ///< at least one
};
std::string to_string(const ClaimQuantity& quantity);

/// What is claimed: that a quantity, the left side over the right one, is between two bounds.
struct ClaimStatement {
  ClaimQuantity quantity;
  double low = 0.0;   ///< 0 where there is none
  double high = 0.0;  ///< infinite where there is none
};

using ClaimVariables = std::map<std::string, std::string>;

/// Both replace variables, whose names they add to `used`. Throw InputError "'TEXT', character 7:
/// found ...; accepted: ...".
ClaimStatement parse_statement(const std::string& text, const ClaimVariables& variables,
                               std::set<std::string>& used);
ClaimQuantity parse_quantity(const std::string& text, const ClaimVariables& variables,
                             std::set<std::string>& used);

/// Whether a text may name a variable: capitals, digits and _, a capital first.
bool is_variable_name(std::string_view text);

}  // namespace occlab
