#include "harness/claims/claim_terms.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string_view>

#include "harness/config.h"
#include "harness/measure.h"
#include "harness/metrics/brightness.h"
#include "harness/metrics/metrics.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

bool equals(const std::string& text, const std::string& value) { return text == value; }
bool is_closeup(const std::string& view, const std::string& closeup) {
  return view.ends_with(" [" + closeup + "]");
}
/// A view's closeups are chosen by `closeup`.
bool is_view(const std::string& text, const std::string& view) {
  return text == view || text.starts_with(view + " [");
}
/// A probe's settings follow its name.
bool is_probe(const std::string& text, const std::string& probe) {
  return text == probe || text.starts_with(probe + ", ");
}

/// A filter that is no parameter of a method.
struct Column {
  std::string_view name;
  std::string Measurement::*field;
  bool (*takes)(const std::string& text, const std::string& value) = equals;
  std::array<std::string_view, 2> accepted = {};  ///< empty: any text
};
constexpr std::array<Column, 7> columns = {
    {{"experiment", &Measurement::experiment},
     {"scene", &Measurement::scene},
     {"view", &Measurement::view, is_view},
     {"closeup", &Measurement::view, is_closeup},
     {"resolution", &Measurement::resolution},
     {"probe", &Measurement::probe, is_probe},
     {"stage", &Measurement::stage, equals, {"unfiltered", "filtered"}}}};

const Column* find_column(std::string_view name) {
  const auto* const found = std::ranges::find(columns, name, &Column::name);
  return found == columns.end() ? nullptr : found;
}

/// No ratio is made of these: a logarithm, and numbers of which one minus them is the error.
bool has_no_ratios(const std::string& metric) { return metric == "psnr" || metric == "ssim"; }

bool has_stage(ClaimMetric kind) {
  return kind != ClaimMetric::time && kind != ClaimMetric::exponent;
}

const MethodInfo& method_of(const ClaimTerm& term, const std::vector<MethodInfo>& methods) {
  const auto found = std::ranges::find(methods, term.method, &MethodInfo::name);
  if (found != methods.end()) return *found;
  std::vector<std::string> names;
  for (const MethodInfo& method : methods) names.push_back(method.name);
  throw InputError(
      fmt::format("unknown method '{}'{}", term.method, accepted_words(term.method, names)));
}

bool has_parameter(const MethodInfo& method, const std::string& name) {
  return name != "seed" &&
         std::ranges::find(method.parameters, name, &Parameter::name) != method.parameters.end();
}

/// What times alone are measured at, beside the methods' parameters.
bool is_axis_of_times(const std::string& name) {
  return name == triangles_axis || name == threads_axis;
}

void check_axis(const std::string& name, const std::string& value) {
  const bool whole = !value.empty() && std::ranges::all_of(value, [](unsigned char c) {
    return std::isdigit(c) != 0;
  });
  if (whole) return;
  throw InputError(fmt::format("{} '{}'; accepted: a whole number", name, value));
}

void check_filter(const std::string& name, const std::string& value, const MethodInfo& method,
                  ClaimMetric kind) {
  if (is_axis_of_times(name) && kind == ClaimMetric::time) return check_axis(name, value);
  if (const Column* const column = find_column(name)) {
    const std::vector<std::string> accepted(column->accepted.begin(), column->accepted.end());
    if (accepted.front().empty() || std::ranges::find(accepted, value) != accepted.end()) return;
    throw InputError(
        fmt::format("unknown {} '{}'{}", name, value, accepted_words(value, accepted)));
  }
  if (!has_parameter(method, name)) {
    throw InputError(fmt::format("unknown filter '{}' of {}{}", name, method.name,
                                 accepted_words(name, filter_names({method}))));
  }
  ParameterSet(method.parameters).set_text(name, value);  // throws
}

bool same_value(const std::string& a, const std::string& b) {
  if (a == b) return true;
  const auto number = [](const std::string& text, double& value) {
    const char* const end = text.data() + text.size();
    return std::from_chars(text.data(), end, value).ptr == end && !text.empty();
  };
  double x = 0.0;
  double y = 0.0;
  return number(a, x) && number(b, y) && x == y;
}

bool passes(const std::string& name, const std::string& value, const Measurement& row) {
  if (const Column* const column = find_column(name)) {
    return column->takes(row.*(column->field), value);
  }
  const std::string* const found = find_parameter(row, name);
  return found && same_value(*found, value);
}

}  // namespace

ClaimMetric claim_metric(const std::string& name) {
  if (name == "noise") return ClaimMetric::noise;
  if (name == "bias_squared") return ClaimMetric::difference;
  if (name.starts_with("time_ms.") && name.size() > 8) return ClaimMetric::time;
  if (name.starts_with("time_exponent.") && std::ranges::count(name, '.') == 2) {
    return ClaimMetric::exponent;
  }
  if (is_brightness_metric(name)) return ClaimMetric::seeds;
  const bool known = std::ranges::find(metrics(), name, &MetricInfo::name) != metrics().end();
  if (known && has_no_ratios(name)) {
    throw InputError(
        fmt::format("'{}': ratios of it mean nothing; accepted: rmse, ciede2000 or "
                    "another metric in which 0 is no error",
                    name));
  }
  if (known) return ClaimMetric::seeds;
  throw InputError(
      fmt::format("unknown metric '{}'{}", name, accepted_words(name, claim_metrics())));
}

std::vector<std::string> claim_metrics() {
  std::vector<std::string> names = {"noise", "bias_squared", "time", "time.PASS",
                                    "time_exponent.AXIS.PASS"};
  for (const MetricInfo& metric : metrics()) {
    if (!has_no_ratios(metric.name)) names.push_back(metric.name);
  }
  for (const BrightnessInfo& metric : brightness_metrics()) names.emplace_back(metric.name);
  return names;
}

std::vector<std::string> filter_names(const std::vector<MethodInfo>& methods) {
  std::vector<std::string> names;
  for (const Column& column : columns) names.emplace_back(column.name);
  names.insert(names.end(), {triangles_axis, threads_axis});
  for (const MethodInfo& method : methods) {
    for (const Parameter& parameter : method.parameters) {
      const bool known = std::ranges::find(names, parameter.name) != names.end();
      if (!known && parameter.name != "seed") names.push_back(parameter.name);
    }
  }
  return names;
}

bool takes_filter(const ClaimTerm& term, const std::string& name,
                  const std::vector<MethodInfo>& methods) {
  if (name == "stage") return has_stage(claim_metric(term.metric));
  if (find_column(name)) return true;
  if (is_axis_of_times(name)) return claim_metric(term.metric) == ClaimMetric::time;
  return has_parameter(method_of(term, methods), name);
}

void check_term(const ClaimTerm& term, const std::vector<MethodInfo>& methods) {
  const ClaimMetric kind = claim_metric(term.metric);
  const MethodInfo& method = method_of(term, methods);
  for (const auto& [name, value] : term.filters) check_filter(name, value, method, kind);
  if (has_stage(kind) != (term.filter("stage") != nullptr)) {
    throw InputError(fmt::format("{}: {}", to_string(term),
                                 has_stage(kind) ? "stage missing; accepted: unfiltered, filtered"
                                                 : "found a stage, which times do not have"));
  }
}

void check_value(const ClaimQuantity& quantity) {
  const ClaimMetric kind = claim_metric(quantity.factors.front().term.metric);
  for (const ClaimFactor& factor : quantity.factors) {
    if (claim_metric(factor.term.metric) != kind) {
      throw InputError(fmt::format(
          "{} and {} are not of a kind; accepted: accuracies, noises, times or exponents alone",
          quantity.factors.front().term.metric, factor.term.metric));
    }
  }
  if (kind == ClaimMetric::difference) {
    throw InputError(
        "bias_squared may be estimated below 0; accepted: a statement 'a > b', 'a < b'");
  }
}

void check_statement(const ClaimStatement& statement) {
  const auto& factors = statement.quantity.factors;
  if (claim_metric(factors.front().term.metric) == ClaimMetric::difference) {
    const bool comparison = factors.size() == 2 && factors[0].power == 1 &&
                            factors[1].power == -1 &&
                            factors[1].term.metric == factors[0].term.metric &&
                            (statement.low == 1.0) != (statement.high == 1.0);
    if (comparison) return;
  }
  check_value(statement.quantity);
}

bool selects(const ClaimTerm& term, const Measurement& row) {
  if (row.metric != term.metric || row.method != term.method) return false;
  if (is_region(row) != (term.filter("closeup") != nullptr)) return false;
  return std::ranges::all_of(term.filters,
                             [&](const auto& f) { return passes(f.first, f.second, row); });
}

}  // namespace occlab
