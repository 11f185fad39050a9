// TomlTable::range: {from, to, step} and {from, to, factor}.

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "harness/config.h"
#include "harness/toml_reader.h"

namespace occlab {
namespace {

/// A range ends where it is beyond `to` by more than rounding.
constexpr double rounding = 1e-9;

double as_real(const ParameterValue& value) {
  const auto* const integer = std::get_if<long>(&value);
  return integer ? double(*integer) : std::get<double>(value);
}

/// With twelve digits: 0.3 is 0.3 and not 0.1 + 2 * 0.1 in binary.
double rounded(double value) { return std::strtod(fmt::format("{:.12g}", value).c_str(), nullptr); }

}  // namespace

std::vector<ParameterValue> TomlTable::range(const std::string& name) {
  TomlTable table = this->table(name);
  bool whole = true;
  const auto number = [&](const char* key) {
    const ParameterValue value = table.values(key, false).front();
    if (std::holds_alternative<std::string>(value) || !std::isfinite(as_real(value))) {
      table.fail(key, fmt::format("found '{}'; accepted is a finite number", to_string(value)));
    }
    // Halves of integers may be integers.
    whole = whole && (std::holds_alternative<long>(value) || std::string(key) == "factor");
    return as_real(value);
  };
  const bool powers = table.has("factor");
  table.has("step");
  table.has("from");
  table.has("to");
  table.refuse_others();
  if (powers && table.has("step")) table.fail("step", "accepted is either a step or a factor");
  const double from = number("from");
  const double to = number("to");
  const char* const last = powers ? "factor" : "step";
  const double by = number(last);
  if (!powers && by == 0.0) table.fail(last, "found 0; accepted is any other number");
  if (powers && !(by > 0.0 && by != 1.0)) {
    table.fail(last, fmt::format("found {:g}; accepted is a positive number that is not 1", by));
  }
  if (powers && !(from * to > 0.0)) {
    table.fail("from", fmt::format("found {:g} to {:g}; powers need both ends above 0, or both "
                                   "below",
                                   from, to));
  }
  const double more = powers ? std::log(to / from) / std::log(by) : (to - from) / by;
  if (more < -rounding) {
    table.fail("to", fmt::format("no value lies between {:g} and {:g} with a {} of {:g}", from, to,
                                 last, by));
  }
  if (more >= double(most_cells)) {
    table.fail(last, fmt::format("the range has {:.0f} values; accepted are at most {}",
                                 std::floor(more) + 1.0, most_cells));
  }
  const long count = long(std::floor(more + rounding)) + 1;
  std::vector<ParameterValue> values;
  for (long i = 0; i < count; ++i) {
    const double value = powers ? from * std::pow(by, double(i)) : from + by * double(i);
    if (whole && std::abs(value) < 9e15 && std::nearbyint(value) == value) {
      values.emplace_back(long(value));
    } else if (whole) {
      table.fail(last,
                 fmt::format("{:g} is not an integer; write reals for a range of reals", value));
    } else {
      values.emplace_back(rounded(value));
    }
  }
  return values;
}

}  // namespace occlab
