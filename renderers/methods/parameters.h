#pragma once

#include <initializer_list>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace occlab {

enum class ParameterKind { integer, real, choice };

/// The independent choices that a method is a product of. What a parameter belongs to says what
/// must be done again when it changes.
enum class Factor { samples, visibility, representation, filter, lighting };

/// A parameter's value: an integer, a real, or one of the declared words.
using ParameterValue = std::variant<long, double, std::string>;

/// One declaration drives the configuration's validation, the shader's constants and uniforms, the
/// sweep axes, the columns and the help text.
struct Parameter {
  std::string name;  ///< a length in scene units ends in `_world`, an angle in `_degrees`
  ParameterKind kind = ParameterKind::real;
  ParameterValue default_value;
  double minimum = -std::numeric_limits<double>::infinity();  ///< accepted, integer and real
  double maximum = std::numeric_limits<double>::infinity();   ///< accepted
  std::string unit;                                           ///< "" if it has none
  std::vector<std::string> choices;                           ///< accepted words of a choice
  std::string help;                                           ///< one sentence, with its source
  /// Whether shaders are told. A seed is not: every new one would compile every pass again.
  bool in_shaders = true;
  Factor factor = Factor::representation;
};

Parameter integer_parameter(std::string name, long value, long minimum, long maximum,
                            std::string unit, std::string help);
Parameter real_parameter(std::string name, double value, double minimum, double maximum,
                         std::string unit, std::string help);
/// `seed`: what a run is repeated with; used on the CPU only.
Parameter seed_parameter(std::string help);
Parameter choice_parameter(std::string name, std::vector<std::string> choices, std::string help);

/// The same parameters, as parts of a factor.
std::vector<Parameter> of_factor(Factor factor, std::vector<Parameter> parameters);

/// "integer in [1, 256]", "one of binary, lambda": what a parameter accepts, for messages and help.
std::string accepted_values(const Parameter& parameter);

/// Values for a list of declared parameters; always complete and always within range.
class ParameterSet {
 public:
  /// All defaults. The declarations outlive the set.
  explicit ParameterSet(const std::vector<Parameter>& declared);

  /// Throws InputError naming the parameter, the value and what is accepted. An integer is taken
  /// for a real parameter, not the other way round.
  void set(std::string_view name, const ParameterValue& value);
  /// The same from text, as `--set NAME=VALUE` gives it.
  void set_text(std::string_view name, std::string_view text);

  long integer(std::string_view name) const;
  double real(std::string_view name) const;
  float real32(std::string_view name) const { return float(real(name)); }
  const std::string& choice(std::string_view name) const;

  bool has(std::string_view name) const;
  const ParameterValue& value(std::string_view name) const;
  std::span<const Parameter> declared() const { return *declared_; }

  /// "samples=32 steps=2 ...", in declared order: part of a cell's identity.
  std::string to_string() const;

  /// The same of those of some factors only.
  std::string to_string(std::initializer_list<Factor> factors) const;

  /// GLSL, of those that are `in_shaders`: integers and choices as `#define PARAMETER_samples 32`,
  /// the words of a choice as
  /// `#define WEIGHT_LAMBDA 1`, reals as `uniform float d_max_world;`.
  std::string glsl_preamble() const;

 private:
  const Parameter& find(std::string_view name) const;

  const std::vector<Parameter>* declared_;
  std::map<std::string, ParameterValue, std::less<>> values_;
};

std::string to_string(const ParameterValue& value);

}  // namespace occlab
