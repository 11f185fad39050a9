#include "harness/claims/claim_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "harness/claims/claim_terms.h"
#include "harness/toml_reader.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr std::size_t most_cases = 1000;  // of a claim

/// A variable and the values it takes.
struct Variable {
  std::string name;
  std::vector<std::string> values;
};

std::vector<Variable> read_variables(TomlTable& claim) {
  std::vector<Variable> variables;
  if (!claim.has("over")) return variables;
  TomlTable over = claim.table("over");
  for (const std::string& name : over.others()) {
    if (!is_variable_name(name)) {
      over.fail(name, "accepted are variables of capitals, digits and _, such as N");
    }
    Variable variable{name, {}};
    for (const ParameterValue& value : over.values(name, true)) {
      variable.values.push_back(to_string(value));
    }
    variables.push_back(std::move(variable));
  }
  return variables;
}

using Filters = std::vector<std::pair<std::string, std::string>>;

Filters read_where(TomlTable& claim, const std::vector<MethodInfo>& methods) {
  Filters filters;
  if (!claim.has("where")) return filters;
  TomlTable where = claim.table("where");
  const std::vector<std::string> known = filter_names(methods);
  for (const std::string& name : where.others()) {
    if (name == "experiment") where.fail(name, "accepted is the claim's own key 'experiment'");
    if (std::ranges::find(known, name) == known.end()) {
      where.fail(name, "unknown" + accepted_words(name, known));
    }
    filters.emplace_back(name, to_string(where.values(name, false).front()));
  }
  return filters;
}

/// Every choice of the variables, the first one varying slowest.
std::vector<ClaimVariables> choices(const std::vector<Variable>& variables) {
  std::vector<ClaimVariables> all = {{}};
  for (const Variable& variable : variables) {
    std::vector<ClaimVariables> longer;
    for (const ClaimVariables& choice : all) {
      for (const std::string& value : variable.values) {
        longer.push_back(choice);
        longer.back()[variable.name] = value;
      }
    }
    all = std::move(longer);
  }
  return all;
}

std::string label(const std::vector<Variable>& variables, const ClaimVariables& choice) {
  std::string text;
  for (const Variable& variable : variables) {
    text +=
        fmt::format("{}{}={}", text.empty() ? "" : ", ", variable.name, choice.at(variable.name));
  }
  return text;
}

/// Reads the cases of one claim.
class CaseReader {
 public:
  CaseReader(TomlTable& table, const Claim& claim, const std::vector<MethodInfo>& methods)
      : table_(table), claim_(claim), methods_(methods), where_(read_where(table, methods)) {}

  std::vector<ClaimCase> read() {
    const std::vector<Variable> variables = read_variables(table_);
    std::size_t count = 1;
    for (const Variable& variable : variables) {
      count *= variable.values.size();
      if (count > most_cases) {
        table_.fail("over", fmt::format("found more than {} cases", most_cases));
      }
    }
    std::vector<ClaimCase> cases;
    for (const ClaimVariables& choice : choices(variables)) {
      cases.push_back({label(variables, choice), {}, {}, {}});
      if (!claim_.statement.empty()) cases.back().statement = statement(choice);
      if (!claim_.value.empty()) cases.back().value = value(choice);
    }
    for (const Variable& variable : variables) {
      if (!used_.contains(variable.name)) {
        table_.fail("over", fmt::format("variable {} is not used", variable.name));
      }
    }
    for (const auto& [name, value] : where_) {
      if (!applied_.contains(name)) {
        table_.fail("where", fmt::format("no method of the claim has a parameter '{}'", name));
      }
    }
    return cases;
  }

 private:
  ClaimStatement statement(const ClaimVariables& choice) {
    try {
      ClaimStatement found = parse_statement(claim_.statement, choice, used_);
      complete(found.quantity, choice);
      check_statement(found);
      return found;
    } catch (const InputError& error) {
      table_.fail("statement", error.what());
    }
  }
  ClaimQuantity value(const ClaimVariables& choice) {
    try {
      ClaimQuantity found = parse_quantity(claim_.value, choice, used_);
      complete(found, choice);
      check_value(found);
      return found;
    } catch (const InputError& error) {
      table_.fail("value", error.what());
    }
  }
  void complete(ClaimQuantity& quantity, const ClaimVariables& choice) {
    for (ClaimFactor& factor : quantity.factors) {
      factor.term.filters.emplace_back("experiment", claim_.experiment);
      for (const auto& [name, written] : where_) {
        const auto variable = choice.find(written);
        if (variable != choice.end()) used_.insert(written);
        const std::string& value = variable == choice.end() ? written : variable->second;
        if (!takes_filter(factor.term, name, methods_)) continue;
        applied_.insert(name);
        if (!factor.term.filter(name)) factor.term.filters.emplace_back(name, value);
      }
      check_term(factor.term, methods_);
    }
  }

  TomlTable& table_;
  const Claim& claim_;
  const std::vector<MethodInfo>& methods_;
  Filters where_;
  std::set<std::string> used_;     // variables
  std::set<std::string> applied_;  // names in `where`
};

void read_published(TomlTable& table, Claim& claim) {
  const bool has_number = table.has("published");
  if (has_number == claim.value.empty()) {
    table.fail(has_number ? "value" : "published",
               "missing; 'value' and 'published' come together");
  }
  if (!has_number) return;
  const std::vector<ParameterValue> numbers = table.values("published", true, true);
  if (numbers.size() != claim.cases.size()) {
    table.fail("published",
               fmt::format("found {} numbers; accepted is one for each of the {} cases",
                           numbers.size(), claim.cases.size()));
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto* const whole = std::get_if<long>(&numbers[i]);
    const auto* const real = std::get_if<double>(&numbers[i]);
    const double value = whole ? double(*whole) : real ? *real : 0.0;
    if (!(value > 0.0)) table.fail("published", "accepted are numbers above 0");
    claim.cases[i].published = value;
  }
}

void read_statement(TomlTable& table, const ClaimFile& file, const std::vector<MethodInfo>& methods,
                    Claim& claim) {
  claim.statement = table.text("statement", "");
  claim.value = table.text("value", "");
  if (claim.statement.empty() && claim.value.empty()) {
    table.fail("statement", "missing; a claim has a 'statement', a 'value' or is 'untestable'");
  }
  claim.experiment = table.identifier("experiment");
  if (!file.commands.contains(claim.experiment)) {
    std::vector<std::string> names;
    for (const auto& [name, command] : file.commands) names.push_back(name);
    table.fail("experiment", fmt::format("unknown '{}'{}", claim.experiment,
                                         accepted_words(claim.experiment, names)));
  }
  claim.hardware = table.one_of("device", {"any", "hardware"}, "any") == "hardware";
  claim.level = table.real("level", 1e-6, file.level, file.level);
  claim.tolerance = table.real("tolerance", 0.0, 1.0, 0.0);
  claim.precision = table.real("precision", 1e-4, 1.0, claim.precision);
  claim.cases = CaseReader(table, claim, methods).read();
  read_published(table, claim);
}

Claim read_claim(TomlTable& table, const ClaimFile& file, const std::vector<MethodInfo>& methods) {
  Claim claim;
  claim.id = table.identifier("id");
  claim.paper = table.one_of("paper", {"s3ho", "ssdo"}, "");
  claim.place = table.text("place");
  claim.text = table.text("text");
  claim.untestable = table.text("untestable", "");
  if (claim.untestable.empty()) read_statement(table, file, methods, claim);
  table.refuse_others();
  return claim;
}

Contradiction read_contradiction(TomlTable& table) {
  Contradiction found;
  found.id = table.identifier("id");
  found.paper = table.one_of("paper", {"s3ho", "ssdo", "both"}, "");
  found.place = table.text("place");
  found.text = table.text("text");
  found.reading = table.text("reading");
  table.refuse_others();
  return found;
}

void require_new(std::set<std::string>& ids, const TomlTable& table, const std::string& id) {
  if (!ids.insert(id).second) table.fail("id", fmt::format("'{}' is there twice", id));
}

}  // namespace

ClaimFile load_claims(const std::filesystem::path& path, const std::vector<MethodInfo>& methods) {
  const toml::table document = parse_toml(path, {});
  TomlTable root(document, "", path.string());
  root.integer("format", 1, 1, std::nullopt);
  ClaimFile file;
  file.level = root.real("level", 1e-6, 0.5, file.level);
  TomlTable experiments = root.table("experiments");
  for (const std::string& name : experiments.others()) {
    file.commands[name] = experiments.text(name);
  }
  std::set<std::string> ids;
  for (TomlTable& table : root.tables("claim")) {
    file.claims.push_back(read_claim(table, file, methods));
    require_new(ids, table, file.claims.back().id);
  }
  if (root.has("contradiction")) {
    for (TomlTable& table : root.tables("contradiction")) {
      file.contradictions.push_back(read_contradiction(table));
      require_new(ids, table, file.contradictions.back().id);
    }
  }
  root.refuse_others();
  return file;
}

}  // namespace occlab
