#include "harness/comparison_tests.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace occlab {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The facts of both without the method.
Facts common_facts(const Facts& a, const Facts& b) {
  Facts facts = a;
  for (const auto& entry : b) {
    if (std::ranges::find(facts, entry.first, &Facts::value_type::first) == facts.end()) {
      facts.push_back(entry);
    }
  }
  std::erase_if(facts, [](const auto& entry) { return entry.first == "method"; });
  return facts;
}

Verdict verdict(const Comparison& comparison, bool rejected) {
  if (!rejected) return Verdict::unresolved;
  return *comparison.value < (comparison.ratio ? 1.0 : 0.0) ? Verdict::less : Verdict::greater;
}

}  // namespace

Comparison new_comparison(const Measurement& a, const Measurement& b) {
  Comparison comparison;
  const Facts facts_of_a = facts_of(a);
  const Facts facts_of_b = facts_of(b);
  comparison.facts = common_facts(facts_of_a, facts_of_b);
  comparison.stage = a.stage;
  comparison.a = a.method;
  comparison.b = b.method;
  comparison.row_of_a = facts_key(facts_of_a);
  comparison.row_of_b = facts_key(facts_of_b);
  return comparison;
}

ComparisonTest test_estimate(Comparison comparison, const Measurement& row) {
  ComparisonTest test{std::move(comparison), std::nullopt, 0.0, {}};
  Comparison& result = test.comparison;
  result.unit = row.unit;
  result.value = row.value;
  result.n = row.n;
  result.reason = row.reason;
  if (!row.value) return test;
  if (!row.lower || row.n < 2 || !std::isfinite(*row.lower) || !std::isfinite(*row.upper)) {
    result.reason = row.n == 1 ? "one seed" : fmt::format("no interval from {} seeds", row.n);
    return test;
  }
  const double null = result.ratio ? 1.0 : 0.0;
  if (*row.lower == *row.upper) {
    // No seed changes anything: as in the paired bootstrap, only so many seeds can vouch for it.
    test.smallest_p = std::pow(double(row.n), 1.0 - double(row.n));
    test.p_value = *row.value == null ? 1.0 : test.smallest_p;
    if (*row.value == null) result.verdict = Verdict::equal;
    test.interval = [value = *row.value, p = *test.p_value, null](double confidence) {
      const bool sure = value == null || p <= 1.0 - confidence;
      return sure ? Interval{value, value, confidence}
                  : Interval{null == 1.0 ? 0.0 : -infinity, infinity, confidence};
    };
    return test;
  }
  if (result.ratio && !(*row.lower > 0.0)) {
    result.reason = "the ratio is 0";
    return test;
  }
  const double half =
      0.5 * (result.ratio ? std::log(*row.upper / *row.lower) : *row.upper - *row.lower);
  const StudentEstimate estimate =
      student_estimate(result.ratio ? std::log(*row.value) : *row.value, half, row.n);
  test.p_value = estimate.p_value(0.0);
  test.interval = [estimate, ratio = result.ratio](double confidence) {
    Interval interval = estimate.interval(confidence);
    if (ratio) interval = {std::exp(interval.low), std::exp(interval.high), confidence};
    return interval;
  };
  return test;
}

Comparisons decide(std::vector<ComparisonTest> tests) {
  Comparisons result;
  std::vector<double> p_values;
  for (const ComparisonTest& test : tests) {
    if (!test.p_value) continue;
    const bool first = p_values.empty();
    result.smallest_p = first ? test.smallest_p : std::min(result.smallest_p, test.smallest_p);
    p_values.push_back(*test.p_value);
  }
  result.tested = p_values.size();
  const std::vector<HolmTest> corrected = holm(p_values, result.level);
  std::size_t next = 0;
  for (ComparisonTest& test : tests) {
    Comparison& comparison = test.comparison;
    if (test.p_value) {
      const HolmTest& holm_test = corrected[next++];
      comparison.adjusted_p = holm_test.adjusted_p;
      const Interval interval = test.interval(1.0 - holm_test.level);
      comparison.lower = interval.low;
      comparison.upper = interval.high;
      comparison.confidence = interval.confidence;
      if (comparison.verdict != Verdict::equal) {
        comparison.verdict = verdict(comparison, holm_test.rejected);
      }
    }
    result.all.push_back(std::move(comparison));
  }
  return result;
}

}  // namespace occlab
