#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "harness/measurements.h"

namespace occlab {

using Facts = std::vector<std::pair<std::string, std::string>>;

/// What tells the rows of a table apart, in the order of its columns: experiment, scene, view,
/// resolution, probe, method and the parameters; empty facts are left out.
Facts facts_of(const Measurement& measurement);

/// The value of a fact, "" if it is not there.
std::string fact(const Facts& facts, const std::string& name);

/// The facts as one text, equal exactly where they are.
std::string facts_key(const Facts& facts);

/// `time_ms.PASS` and `time_ratio.PASS`.
bool is_time(const Measurement& measurement);

/// `time_exponent.AXIS.PASS`: how a time grows with what is varied (timing_rows.h).
bool is_exponent(const Measurement& measurement);

/// noise, bias, bias_squared, mse: what only several seeds together can tell.
bool is_over_seeds(const Measurement& measurement);

/// `noise_spectrum.FREQUENCY`: the power of the noise at a frequency (power_spectrum.h).
bool is_spectrum(const Measurement& measurement);

/// A metric that compares two methods: "noise_ratio.ssdo/s3ho" is noise of ssdo / noise of s3ho,
/// "bias_squared_difference.ssdo/s3ho" bias_squared of ssdo - bias_squared of s3ho.
struct ComparedMetric {
  std::string quantity;
  std::string a;
  std::string b;
  bool ratio = false;
};
/// Nothing for any other metric.
std::optional<ComparedMetric> compared_metric(const std::string& metric);

/// `budget_...` and `failure_...`: parts of the error (error_budget.h).
bool is_budget(const Measurement& measurement);

/// `reference_...`: how well the reference is known (certification.h).
bool is_of_reference(const Measurement& measurement);

/// `mean_red` and its like: a picture's own brightness, which is no error (metrics/brightness.h).
bool is_brightness(const Measurement& measurement);

/// A metric of one image against the reference: neither a time, nor over seeds, nor a
/// brightness, nor a spectrum's, nor comparing, nor a part of the error.
bool is_accuracy(const Measurement& measurement);

/// Two rows that stand for two methods under the same conditions: all is equal, parameters that
/// only one of them has apart.
bool comparable(const Measurement& a, const Measurement& b);

}  // namespace occlab
