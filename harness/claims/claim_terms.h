#pragma once

#include <string>
#include <vector>

#include "harness/claims/statement.h"
#include "harness/measurements.h"
#include "renderers/methods/method.h"

namespace occlab {

/// What is known of a metric of claims, which decides on its statistics.
enum class ClaimMetric {
  seeds,       ///< an accuracy, or a brightness: a value for every seed
  noise,       ///< over the seeds, with a jackknife interval
  difference,  ///< bias_squared, which may be estimated below 0: differences alone have a meaning
  time,        ///< time_ms.PASS
  exponent,    ///< time_exponent.AXIS.PASS
};

/// Throws InputError for an unknown metric, or one that no ratio is made of, such as decibels.
ClaimMetric claim_metric(const std::string& name);

/// The names that claim_metric accepts.
std::vector<std::string> claim_metrics();

/// Columns, `closeup` and the parameters of all methods: what a filter may be called.
std::vector<std::string> filter_names(const std::vector<MethodInfo>& methods);

/// Whether a filter of `where` means the rows of this term: a column always, a parameter where the
/// method has it, a stage where the metric has one.
bool takes_filter(const ClaimTerm& term, const std::string& name,
                  const std::vector<MethodInfo>& methods);

/// Throws InputError for an unknown metric, method or filter, a value that the parameter does not
/// accept, and a stage that is missing or has no meaning.
void check_term(const ClaimTerm& term, const std::vector<MethodInfo>& methods);

/// What can be estimated: all terms of one kind; of bias_squared two terms and `>` or `<` alone.
void check_statement(const ClaimStatement& statement);
void check_value(const ClaimQuantity& quantity);

/// Whether a row is one that a term means. Without the filter `closeup`, parts of views are not.
bool selects(const ClaimTerm& term, const Measurement& row);

}  // namespace occlab
