#include "harness/claims/estimates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "harness/claims/claim_terms.h"
#include "harness/measurement_facts.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

/// Nothing can be said, and why.
struct NotMeasured {
  std::string reason;
};

/// The rows that one term means: those of its seeds, and that over all of them.
struct TermRows {
  const MeasuredFolder* folder = nullptr;
  Facts facts;
  const Measurement* all = nullptr;
  std::map<std::string, const Measurement*> seeds;
};

/// Which fact tells two groups of rows apart.
std::string difference(const Facts& a, const Facts& b) {
  for (const auto& [name, value] : a) {
    if (fact(b, name) != value) {
      return fmt::format("{} is '{}' in one and '{}' in another", name, value, fact(b, name));
    }
  }
  return "they are of two folders or stages";
}

std::string described(const ClaimTerm& term) {
  std::set<std::string> names;
  for (const auto& [name, value] : term.filters) names.insert(name);
  return to_string(term, names);
}

TermRows find_rows(const ClaimTerm& term, const std::vector<MeasuredFolder>& folders) {
  TermRows found;
  std::string key;
  for (const MeasuredFolder& folder : folders) {
    for (const Measurement& row : folder.rows) {
      if (!selects(term, row)) continue;
      const Facts facts = facts_of(row);
      if (!found.folder) {
        found.folder = &folder;
        found.facts = facts;
        key = facts_key(facts);
      } else if (found.folder != &folder || facts_key(facts) != key) {
        throw InputError(fmt::format(
            "several measurements fit {}: {}", described(term),
            found.folder == &folder ? difference(found.facts, facts)
                                    : found.folder->name + " and " + folder.name + " have it"));
      }
      if (row.seed == "all") {
        found.all = &row;
      } else {
        found.seeds[row.seed] = &row;
      }
    }
  }
  if (!found.folder) throw NotMeasured{"not measured: " + described(term)};
  return found;
}

const Measurement& over_all(const TermRows& rows, const ClaimTerm& term) {
  if (!rows.all) throw NotMeasured{"not measured over all seeds: " + described(term)};
  if (!rows.all->value) throw NotMeasured{fmt::format("{}: {}", described(term), rows.all->reason)};
  return *rows.all;
}

/// A logarithm with the standard errors below and above it, of a Student distribution.
struct LogEstimate {
  double value = 0.0;
  double error_below = 0.0;
  double error_above = 0.0;
  long n = 0;
};

double log_of(double value, const ClaimTerm& term) {
  if (value > 0.0 && std::isfinite(value)) return std::log(value);
  throw NotMeasured{
      fmt::format("{} is {:g}; a ratio needs finite values above 0", described(term), value)};
}

double student_95(long n) { return student_quantile(0.975, double(n - 1)); }

/// Of a row whose interval is one of 95%.
LogEstimate from_interval(const Measurement& row, const ClaimTerm& term) {
  if (!row.lower || row.n < 2) {
    throw NotMeasured{fmt::format("stored without an interval: {}", described(term))};
  }
  const double value = log_of(*row.value, term);
  const double quantile = student_95(row.n);
  return {value, (value - log_of(*row.lower, term)) / quantile,
          (log_of(*row.upper, term) - value) / quantile, row.n};
}

/// Of a median in ms, whose bounds are quartiles. For normal values the quartiles are 1.349 sigma
/// apart, and the median of n has the standard error sqrt(pi / 2) sigma / sqrt(n).
LogEstimate from_quartiles(const Measurement& row, const ClaimTerm& term) {
  if (!row.lower || row.n < 2) {
    throw NotMeasured{fmt::format("stored without quartiles: {}", described(term))};
  }
  const double sigma = (*row.upper - *row.lower) / 1.349;
  const double error = std::sqrt(0.5 * std::numbers::pi / double(row.n)) * sigma / *row.value;
  return {log_of(*row.value, term), error, error, row.n};
}

LogEstimate power(LogEstimate estimate, int power) {
  if (power > 0) return estimate;
  return {-estimate.value, estimate.error_above, estimate.error_below, estimate.n};
}

/// Whatever the dependence, the standard error of a sum is at most the sum of the standard errors.
LogEstimate sum(const std::vector<LogEstimate>& parts) {
  LogEstimate total = parts.front();
  for (auto part = parts.begin() + 1; part != parts.end(); ++part) {
    total.value += part->value;
    total.error_below += part->error_below;
    total.error_above += part->error_above;
    total.n = std::min(total.n, part->n);
  }
  return total;
}

/// What was found for one factor of a quantity.
struct MeasuredFactor {
  const ClaimTerm* term = nullptr;
  int power = 1;
  TermRows rows;
};

/// "noise_ratio.A/B" of two rows, or of B over A; the stored pair has the cells of both.
std::optional<LogEstimate> stored_noise_ratio(const MeasuredFactor& above,
                                              const MeasuredFactor& below) {
  const Measurement& a = over_all(above.rows, *above.term);
  const Measurement& b = over_all(below.rows, *below.term);
  if (above.rows.folder != below.rows.folder || a.cells.empty() || b.cells.empty()) {
    return std::nullopt;
  }
  const auto holds = [](const Measurement& pair, const Measurement& one) {
    return std::ranges::all_of(one.cells, [&](const std::string& cell) {
      return std::ranges::find(pair.cells, cell) != pair.cells.end();
    });
  };
  for (const auto& [metric, sign] :
       {std::pair(fmt::format("noise_ratio.{}/{}", a.method, b.method), 1),
        std::pair(fmt::format("noise_ratio.{}/{}", b.method, a.method), -1)}) {
    for (const Measurement& row : above.rows.folder->rows) {
      if (row.metric != metric || row.stage != a.stage || row.view != a.view || row.seed != "all" ||
          !holds(row, a) || !holds(row, b) || !row.value || !row.lower) {
        continue;
      }
      return power(from_interval(row, *above.term), sign);
    }
  }
  return std::nullopt;
}

/// The row `time_ratio.PASS` of the same facts as a time.
const Measurement* ratio_to_baseline(const MeasuredFactor& factor) {
  const Measurement& time = over_all(factor.rows, *factor.term);
  const std::string metric = "time_ratio." + time.metric.substr(time.metric.find('.') + 1);
  const std::string key = facts_key(factor.rows.facts);
  for (const Measurement& row : factor.rows.folder->rows) {
    if (row.metric == metric && row.value && row.lower && facts_key(facts_of(row)) == key) {
      return &row;
    }
  }
  return nullptr;
}

/// Of two times that have the same baseline: through their ratios to it.
std::optional<LogEstimate> stored_time_ratio(const MeasuredFactor& above,
                                             const MeasuredFactor& below) {
  const Measurement& a = over_all(above.rows, *above.term);
  const Measurement& b = over_all(below.rows, *below.term);
  if (above.rows.folder != below.rows.folder || !comparable(a, b)) return std::nullopt;
  const Measurement* const ratio_a = ratio_to_baseline(above);
  const Measurement* const ratio_b = ratio_to_baseline(below);
  if (!ratio_a || !ratio_b) return std::nullopt;
  return sum(
      {from_interval(*ratio_a, *above.term), power(from_interval(*ratio_b, *below.term), -1)});
}

/// Pairs what was measured as a pair, and adds up the rest.
LogEstimate combine(std::vector<MeasuredFactor> factors, ClaimMetric kind) {
  std::vector<LogEstimate> parts;
  const auto pair = [&](const MeasuredFactor& above,
                        const MeasuredFactor& below) -> std::optional<LogEstimate> {
    if (kind == ClaimMetric::noise) return stored_noise_ratio(above, below);
    if (kind == ClaimMetric::time) return stored_time_ratio(above, below);
    return std::nullopt;
  };
  for (std::size_t i = 0; i < factors.size(); ++i) {
    if (!factors[i].term) continue;
    std::optional<LogEstimate> found;
    for (std::size_t j = i + 1; j < factors.size() && !found; ++j) {
      if (!factors[j].term || factors[i].power == factors[j].power) continue;
      const bool first_above = factors[i].power > 0;
      found = pair(factors[first_above ? i : j], factors[first_above ? j : i]);
      if (found) factors[j].term = nullptr;
    }
    if (!found) {
      const Measurement& row = over_all(factors[i].rows, *factors[i].term);
      found = power(kind == ClaimMetric::time ? from_quartiles(row, *factors[i].term)
                                              : from_interval(row, *factors[i].term),
                    factors[i].power);
    }
    parts.push_back(*found);
  }
  return sum(parts);
}

/// The test and the interval of a logarithm, in the quantity's own scale.
ClaimEstimate from_logarithm(const LogEstimate& estimate) {
  ClaimEstimate result;
  result.value = std::exp(estimate.value);
  result.n = estimate.n;
  const double degrees = double(estimate.n - 1);
  const double smallest = std::pow(double(estimate.n), 1.0 - double(estimate.n));
  result.p_value = [estimate, degrees, smallest](double bound) {
    const double distance = estimate.value - std::log(bound);
    if (distance == 0.0) return 1.0;
    const double error = distance > 0.0 ? estimate.error_below : estimate.error_above;
    // Values that do not vary at all: only so many of them can vouch for it.
    return error > 0.0 ? 2.0 * student_cdf(-std::abs(distance) / error, degrees) : smallest;
  };
  result.interval = [estimate, degrees](double confidence) {
    const double quantile = student_quantile(0.5 + 0.5 * confidence, degrees);
    return Interval{std::exp(estimate.value - quantile * estimate.error_below),
                    std::exp(estimate.value + quantile * estimate.error_above), confidence};
  };
  return result;
}

ClaimEstimate from_stored(const std::vector<MeasuredFactor>& factors, ClaimMetric kind) {
  ClaimEstimate result = from_logarithm(combine(factors, kind));
  const Measurement& row = over_all(factors.front().rows, *factors.front().term);
  if (factors.size() == 1) result.unit = row.unit;
  result.how = fmt::format("{} {}", result.n, kind == ClaimMetric::noise ? "seeds" : "repetitions");
  return result;
}

/// The logarithm of the quantity for every seed, which all factors must have.
std::vector<double> seed_values(const std::vector<MeasuredFactor>& factors) {
  std::vector<double> values;
  for (const auto& [seed, unused] : factors.front().rows.seeds) {
    double value = 0.0;
    for (const MeasuredFactor& factor : factors) {
      const auto row = factor.rows.seeds.find(seed);
      if (row == factor.rows.seeds.end() ||
          factor.rows.seeds.size() != factors.front().rows.seeds.size()) {
        throw NotMeasured{"measured with different seeds: " + described(*factor.term)};
      }
      if (!row->second->value) {
        throw NotMeasured{fmt::format("{}: {}", described(*factor.term), row->second->reason)};
      }
      value += factor.power * log_of(*row->second->value, *factor.term);
    }
    values.push_back(value);
  }
  if (values.size() < 2) throw NotMeasured{"one seed: " + described(*factors.front().term)};
  return values;
}

ClaimEstimate from_seeds(const std::vector<MeasuredFactor>& factors,
                         const PairedBootstrap& bootstrap, const std::vector<double>& values) {
  ClaimEstimate result;
  result.value = std::exp(mean(values));
  result.n = long(values.size());
  result.smallest_p = bootstrap.smallest_p();
  if (factors.size() == 1) result.unit = factors.front().rows.seeds.begin()->second->unit;
  result.how = fmt::format("{} {}seeds", values.size(), factors.size() > 1 ? "paired " : "");
  result.p_value = [&bootstrap, values](double bound) {
    std::vector<double> differences = values;
    for (double& value : differences) value -= std::log(bound);
    return bootstrap.test(differences).p_value;
  };
  result.interval = [&bootstrap, values](double confidence) {
    const Interval interval = bootstrap.interval(values, confidence);
    return Interval{std::exp(interval.low), std::exp(interval.high), confidence};
  };
  return result;
}

/// bias_squared of the first less that of the second.
ClaimEstimate from_difference(const MeasuredFactor& a, const MeasuredFactor& b) {
  const Measurement& row_a = over_all(a.rows, *a.term);
  const Measurement& row_b = over_all(b.rows, *b.term);
  const auto has_both = [&](const Measurement& row) {
    const auto holds = [&](const Measurement& one) {
      return !one.cells.empty() && std::ranges::all_of(one.cells, [&](const std::string& cell) {
        return std::ranges::find(row.cells, cell) != row.cells.end();
      });
    };
    return row.stage == row_a.stage && row.view == row_a.view && holds(row_a) && holds(row_b);
  };
  const std::string forward =
      fmt::format("bias_squared_difference.{}/{}", row_a.method, row_b.method);
  const std::string backward =
      fmt::format("bias_squared_difference.{}/{}", row_b.method, row_a.method);
  for (const Measurement& row : a.rows.folder->rows) {
    if ((row.metric != forward && row.metric != backward) || !has_both(row)) continue;
    if (!row.value || !row.lower || row.n < 2 || !(*row.lower < *row.upper)) break;
    const double sign = row.metric == forward ? 1.0 : -1.0;
    const StudentEstimate estimate =
        student_estimate(sign * *row.value, 0.5 * (*row.upper - *row.lower), row.n);
    ClaimEstimate result;
    result.difference = true;
    result.value = estimate.value;
    result.n = row.n;
    result.unit = row.unit;
    result.how = fmt::format("{} paired seeds", row.n);
    result.p_value = [estimate](double bound) { return estimate.p_value(bound); };
    result.interval = [estimate](double confidence) { return estimate.interval(confidence); };
    return result;
  }
  throw NotMeasured{fmt::format("no difference with an interval: {} and {}", described(*a.term),
                                described(*b.term))};
}

}  // namespace

const PairedBootstrap& ClaimEstimator::bootstrap(std::size_t seeds) {
  constexpr Resampling resampling{.resamples = 9999};  // a p-value of 1e-4, below .05 / 100 claims
  return bootstraps_.try_emplace(seeds, seeds, std::size_t(1), resampling).first->second;
}

ClaimEstimate ClaimEstimator::estimate(const ClaimQuantity& quantity) {
  ClaimEstimate result;
  try {
    std::vector<MeasuredFactor> factors;
    for (const ClaimFactor& factor : quantity.factors) {
      factors.push_back({&factor.term, factor.power, find_rows(factor.term, *folders_)});
    }
    const ClaimMetric kind = claim_metric(factors.front().term->metric);
    if (kind == ClaimMetric::seeds) {
      const std::vector<double> values = seed_values(factors);
      result = from_seeds(factors, bootstrap(values.size()), values);
    } else if (kind == ClaimMetric::difference) {
      result = from_difference(factors[0], factors[1]);
    } else {
      result = from_stored(factors, kind);
    }
    const TermRows& rows = factors.front().rows;
    result.folder = rows.folder->name;
    result.device = (rows.all ? rows.all : rows.seeds.begin()->second)->device;
  } catch (const NotMeasured& found) {
    result = {};
    result.reason = found.reason;
  }
  return result;
}

}  // namespace occlab
