#include "renderers/methods/parameters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

std::string upper(std::string_view text) {
  std::string result(text);
  std::ranges::transform(result, result.begin(),
                         [](unsigned char c) { return char(std::toupper(c)); });
  return result;
}

[[noreturn]] void refuse(const Parameter& parameter, const std::string& found) {
  throw InputError(
      fmt::format("{} = {}: accepted is {}", parameter.name, found, accepted_values(parameter)));
}

}  // namespace

Parameter integer_parameter(std::string name, long value, long minimum, long maximum,
                            std::string unit, std::string help) {
  return {std::move(name),
          ParameterKind::integer,
          value,
          double(minimum),
          double(maximum),
          std::move(unit),
          {},
          std::move(help),
          true,
          Factor::representation};
}

Parameter real_parameter(std::string name, double value, double minimum, double maximum,
                         std::string unit, std::string help) {
  return {std::move(name),
          ParameterKind::real,
          value,
          minimum,
          maximum,
          std::move(unit),
          {},
          std::move(help),
          true,
          Factor::representation};
}

Parameter seed_parameter(std::string help) {
  Parameter parameter = integer_parameter("seed", 0, 0, 1'000'000'000, "", std::move(help));
  parameter.in_shaders = false;
  return parameter;
}

Parameter choice_parameter(std::string name, std::vector<std::string> choices, std::string help) {
  Parameter parameter;
  parameter.name = std::move(name);
  parameter.kind = ParameterKind::choice;
  parameter.default_value = choices.front();
  parameter.choices = std::move(choices);
  parameter.help = std::move(help);
  return parameter;
}

std::vector<Parameter> of_factor(Factor factor, std::vector<Parameter> parameters) {
  for (Parameter& parameter : parameters) parameter.factor = factor;
  return parameters;
}

std::string accepted_values(const Parameter& parameter) {
  switch (parameter.kind) {
    case ParameterKind::choice:
      return fmt::format("one of {}", fmt::join(parameter.choices, ", "));
    case ParameterKind::integer:
      // As integers: %g would round 2^24 to 1.67772e+07.
      return fmt::format("an integer in [{:.0f}, {:.0f}]", parameter.minimum, parameter.maximum);
    case ParameterKind::real:
      break;
  }
  return fmt::format("a number in [{:g}, {:g}]{}", parameter.minimum, parameter.maximum,
                     parameter.unit.empty() ? "" : " (" + parameter.unit + ")");
}

std::string to_string(const ParameterValue& value) {
  return std::visit([](const auto& v) { return fmt::format("{}", v); }, value);
}

ParameterSet::ParameterSet(const std::vector<Parameter>& declared) : declared_(&declared) {
  for (const Parameter& parameter : declared) values_[parameter.name] = parameter.default_value;
}

const Parameter& ParameterSet::find(std::string_view name) const {
  const auto parameter = std::ranges::find(*declared_, name, &Parameter::name);
  if (parameter == declared_->end()) {
    std::vector<std::string> names;
    for (const Parameter& candidate : *declared_) names.push_back(candidate.name);
    throw InputError(fmt::format("unknown parameter '{}'{}", name, accepted_words(name, names)));
  }
  return *parameter;
}

void ParameterSet::set(std::string_view name, const ParameterValue& value) {
  const Parameter& parameter = find(name);
  const std::string found = occlab::to_string(value);
  ParameterValue accepted = value;
  switch (parameter.kind) {
    case ParameterKind::choice: {
      const auto* word = std::get_if<std::string>(&value);
      if (!word || std::ranges::find(parameter.choices, *word) == parameter.choices.end()) {
        refuse(parameter, found);
      }
      break;
    }
    case ParameterKind::integer: {
      const auto* number = std::get_if<long>(&value);
      if (!number || double(*number) < parameter.minimum || double(*number) > parameter.maximum) {
        refuse(parameter, found);
      }
      break;
    }
    case ParameterKind::real: {
      if (const auto* number = std::get_if<long>(&value)) accepted = double(*number);
      const auto* number = std::get_if<double>(&accepted);
      if (!number || !(*number >= parameter.minimum && *number <= parameter.maximum)) {
        refuse(parameter, found);
      }
      break;
    }
  }
  values_.find(name)->second = std::move(accepted);
}

void ParameterSet::set_text(std::string_view name, std::string_view text) {
  const Parameter& parameter = find(name);
  const char* const end = text.data() + text.size();
  if (parameter.kind == ParameterKind::choice) {
    set(name, std::string(text));
  } else if (long integer = 0; parameter.kind == ParameterKind::integer) {
    const auto [rest, error] = std::from_chars(text.data(), end, integer);
    if (error != std::errc() || rest != end) refuse(parameter, std::string(text));
    set(name, integer);
  } else {
    double real = 0;
    const auto [rest, error] = std::from_chars(text.data(), end, real);
    if (error != std::errc() || rest != end) refuse(parameter, std::string(text));
    set(name, real);
  }
}

bool ParameterSet::has(std::string_view name) const { return values_.contains(name); }

const ParameterValue& ParameterSet::value(std::string_view name) const {
  const auto entry = values_.find(name);
  assert(entry != values_.end());
  return entry->second;
}

long ParameterSet::integer(std::string_view name) const { return std::get<long>(value(name)); }
double ParameterSet::real(std::string_view name) const { return std::get<double>(value(name)); }
const std::string& ParameterSet::choice(std::string_view name) const {
  return std::get<std::string>(value(name));
}

std::string ParameterSet::to_string() const {
  return to_string({Factor::samples, Factor::visibility, Factor::representation, Factor::filter,
                    Factor::lighting});
}

std::string ParameterSet::to_string(std::initializer_list<Factor> factors) const {
  std::vector<std::string> parts;
  for (const Parameter& parameter : *declared_) {
    if (std::ranges::find(factors, parameter.factor) == factors.end()) continue;
    parts.push_back(fmt::format("{}={}", parameter.name, occlab::to_string(value(parameter.name))));
  }
  return fmt::format("{}", fmt::join(parts, " "));
}

std::string ParameterSet::glsl_preamble() const {
  std::string glsl;
  for (const Parameter& parameter : *declared_) {
    if (!parameter.in_shaders) continue;
    const std::string& name = parameter.name;
    switch (parameter.kind) {
      case ParameterKind::integer:
        glsl += fmt::format("#define PARAMETER_{} {}\n", name, integer(name));
        break;
      case ParameterKind::real:
        glsl += fmt::format("uniform float {};\n", name);
        break;
      case ParameterKind::choice:
        for (std::size_t i = 0; i < parameter.choices.size(); ++i) {
          glsl += fmt::format("#define {}_{} {}\n", upper(name), upper(parameter.choices[i]), i);
        }
        glsl += fmt::format("#define PARAMETER_{} {}_{}\n", name, upper(name), upper(choice(name)));
        break;
    }
  }
  return glsl;
}

}  // namespace occlab
