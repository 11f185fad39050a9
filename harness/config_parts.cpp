#include "harness/config_parts.h"

#include <fmt/format.h>

#include <algorithm>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

std::vector<std::string> parameter_names(const std::vector<const MethodInfo*>& methods) {
  std::vector<std::string> names;
  for (const MethodInfo* method : methods) {
    for (const Parameter& parameter : method->parameters) {
      if (std::ranges::find(names, parameter.name) == names.end()) names.push_back(parameter.name);
    }
  }
  return names;
}

/// Words such as gbuffer_bits' 16 may be written as numbers.
bool is_choice(const std::vector<const MethodInfo*>& methods, const std::string& name) {
  return std::ranges::any_of(methods, [&](const MethodInfo* method) {
    return std::ranges::any_of(method->parameters, [&](const Parameter& parameter) {
      return parameter.name == name && parameter.kind == ParameterKind::choice;
    });
  });
}

}  // namespace

bool declares(const MethodInfo& method, const std::string& parameter) {
  return std::ranges::find(method.parameters, parameter, &Parameter::name) !=
         method.parameters.end();
}

std::vector<const MethodInfo*> known_methods(const TomlTable& table, const std::string& key,
                                             const std::vector<std::string>& names,
                                             const std::vector<MethodInfo>& methods) {
  std::vector<std::string> accepted;
  for (const MethodInfo& method : methods) accepted.push_back(method.name);
  std::vector<const MethodInfo*> result;
  for (const std::string& name : names) {
    const auto method = std::ranges::find(methods, name, &MethodInfo::name);
    if (method == methods.end()) {
      table.fail(key, fmt::format("unknown method '{}'{}", name, accepted_words(name, accepted)));
    }
    result.push_back(&*method);
  }
  return result;
}

std::vector<Axis> read_parameters(TomlTable& table, const std::vector<const MethodInfo*>& methods,
                                  const ParameterRules& rules) {
  std::vector<std::string> accepted = parameter_names(methods);
  if (!rules.own_seed) std::erase(accepted, "seed");
  std::vector<Axis> axes;
  for (const std::string& name : table.others()) {
    if (name == "seed" && !rules.own_seed) {
      table.fail(name, "not accepted here: [[run]] has 'seeds', [reference] its own 'seed'");
    }
    if (std::ranges::find(accepted, name) == accepted.end()) table.refuse_unknown(name, accepted);
    const bool zipped = std::ranges::any_of(
        rules.zips, [&](const auto& zip) { return std::ranges::find(zip, name) != zip.end(); });
    Axis axis{name, table.values(name, rules.lists, zipped)};
    if (is_choice(methods, name)) {
      for (ParameterValue& value : axis.values) value = to_string(value);
    }
    for (const MethodInfo* method : methods) {
      if (!declares(*method, name)) {
        if (!rules.by_all) continue;
        table.fail(name, fmt::format("method '{}' does not declare it{}", method->name,
                                     accepted_words(name, parameter_names({method}))));
      }
      ParameterSet values(method->parameters);
      try {
        for (const ParameterValue& value : axis.values) values.set(name, value);
      } catch (const InputError& error) {
        table.fail(name, error.what());
      }
    }
    axes.push_back(std::move(axis));
  }
  return axes;
}

NamedValues single_values(const std::vector<Axis>& axes) {
  NamedValues values;
  for (const Axis& axis : axes) values.emplace_back(axis.parameter, axis.values.front());
  return values;
}

}  // namespace occlab
