#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <unordered_map>
#include <utility>

#include "harness/comparison_tests.h"
#include "harness/measure.h"
#include "harness/paired_bootstrap.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

/// What the seeds of a method and its parameters gave in one metric.
struct SeedValues {
  std::map<std::string, double> values;
  std::string reason;  ///< why a seed has none
};

/// One row of an accuracy table: a method and its parameters.
struct Variant {
  const Measurement* first = nullptr;
  std::map<std::string, SeedValues> metrics;
};

/// In order of appearance, like the metrics and their units.
struct Variants {
  std::vector<Variant> rows;
  std::vector<std::pair<std::string, std::string>> metrics;
};

Variants collect_variants(const std::vector<Measurement>& measurements, const std::string& stage) {
  Variants variants;
  std::unordered_map<std::string, std::size_t> places;
  for (const Measurement& m : measurements) {
    if (m.stage != stage || !is_accuracy(m)) continue;
    const auto [place, added] = places.try_emplace(facts_key(facts_of(m)), variants.rows.size());
    if (added) variants.rows.push_back({&m, {}});
    if (std::ranges::find(variants.metrics, m.metric, [](const auto& metric) {
          return metric.first;
        }) == variants.metrics.end()) {
      variants.metrics.emplace_back(m.metric, m.unit);
    }
    if (m.seed == "all") continue;
    SeedValues& metric = variants.rows[place->second].metrics[m.metric];
    if (!m.value) {
      metric.reason = fmt::format("{}: {}", m.method, m.reason);
    } else if (!metric.values.emplace(m.seed, *m.value).second) {
      throw InputError(fmt::format("measurements: '{}' of {}, seed {}, is there twice", m.metric,
                                   m.method, m.seed));
    }
  }
  return variants;
}

/// The differences of two methods in one metric: `seeds` for each of the views, view by view.
struct Differences {
  Comparison comparison;
  std::vector<std::string> seeds;
  std::vector<double> values;
  std::size_t views = 1;
  bool closeup = false;  ///< of a part of a view
};

/// Why there are no differences, or "".
std::string fill_differences(Differences& result, const SeedValues* a, const SeedValues* b) {
  for (const SeedValues* metric : {a, b}) {
    if (!metric || (metric->values.empty() && metric->reason.empty())) return "not measured";
    if (!metric->reason.empty()) return metric->reason;
  }
  const auto same_seed = [](const auto& x, const auto& y) { return x.first == y.first; };
  if (!std::ranges::equal(a->values, b->values, same_seed)) return "measured with different seeds";
  for (const auto& [seed, value] : a->values) {
    const double other = b->values.at(seed);
    // Equal infinities, such as the PSNR of two perfect images, are equal.
    const double difference = value == other ? 0.0 : value - other;
    if (!std::isfinite(difference)) return "a value is infinite";
    result.seeds.push_back(seed);
    result.values.push_back(difference);
  }
  return "";
}

Differences differences_of(const Variant& a, const Variant& b, const std::string& metric,
                           const std::string& unit) {
  const auto find = [&](const Variant& variant) -> const SeedValues* {
    const auto found = variant.metrics.find(metric);
    return found == variant.metrics.end() ? nullptr : &found->second;
  };
  Differences result{new_comparison(*a.first, *b.first), {}, {}, 1, is_region(*a.first)};
  result.comparison.quantity = metric;
  result.comparison.unit = unit;
  result.comparison.reason = fill_differences(result, find(a), find(b));
  if (!result.comparison.reason.empty()) {
    result.seeds.clear();
    result.values.clear();
  }
  return result;
}

/// The differences of the same methods, parameters and metric in several views as one.
Differences pool(const std::vector<const Differences*>& views) {
  Differences result{views.front()->comparison, views.front()->seeds, {}, views.size(), false};
  Comparison& comparison = result.comparison;
  comparison.row_of_a = comparison.row_of_b = "";
  for (auto& [name, value] : comparison.facts) {
    const bool same = std::ranges::all_of(views, [&, &fact_name = name, &one = value](auto* view) {
      return fact(view->comparison.facts, fact_name) == one;
    });
    if (!same) value = fmt::format("all {}", views.size());
  }
  for (const Differences* view : views) {
    if (view->values.empty() || view->seeds != result.seeds) {
      comparison.reason = "not measured with the same seeds in every view";
      result.values.clear();
      break;
    }
    result.values.insert(result.values.end(), view->values.begin(), view->values.end());
  }
  return result;
}

std::vector<Differences> pooled_over_views(const std::vector<Differences>& all) {
  std::vector<std::string> order;
  std::unordered_map<std::string, std::vector<const Differences*>> groups;
  for (const Differences& differences : all) {
    if (differences.closeup) continue;
    const Comparison& comparison = differences.comparison;
    Facts facts = comparison.facts;
    std::erase_if(facts, [](const auto& f) { return f.first == "scene" || f.first == "view"; });
    facts.emplace_back("a", comparison.a);
    facts.emplace_back("b", comparison.b);
    facts.emplace_back("quantity", comparison.quantity);
    const std::string key = facts_key(facts);
    auto& group = groups[key];
    if (group.empty()) order.push_back(key);
    group.push_back(&differences);
  }
  std::vector<Differences> pooled;
  for (const std::string& key : order) {
    if (groups[key].size() > 1) pooled.push_back(pool(groups[key]));
  }
  return pooled;
}

/// Resamples enough that the smallest p-value, times the family's size, is half of the level, up to
/// families of 2500.
int resamples_for(std::size_t family, double level) {
  constexpr double least = 9999.0;
  constexpr double most = 99999.0;
  return int(std::clamp(std::ceil(2.0 * double(family) / level), least, most));
}

/// One bootstrap for every number of seeds and views there is.
class Bootstraps {
 public:
  explicit Bootstraps(int resamples) : resamples_(resamples) {}
  const PairedBootstrap& of(const Differences& differences) {
    const auto shape = std::pair(differences.seeds.size(), differences.views);
    return made_.try_emplace(shape, shape.first, shape.second, Resampling{.resamples = resamples_})
        .first->second;
  }

 private:
  int resamples_;
  std::map<std::pair<std::size_t, std::size_t>, PairedBootstrap> made_;
};

ComparisonTest test_differences(const Differences& differences, Bootstraps& bootstraps) {
  ComparisonTest test{differences.comparison, std::nullopt, 0.0, {}};
  Comparison& comparison = test.comparison;
  if (differences.values.empty()) return test;
  comparison.value = mean(differences.values);
  comparison.n = long(differences.seeds.size());
  if (comparison.n == 1) {
    comparison.reason = "one seed";
    return test;
  }
  const PairedBootstrap& bootstrap = bootstraps.of(differences);
  test.p_value = bootstrap.test(differences.values).p_value;
  test.smallest_p = bootstrap.smallest_p();
  test.interval = [&differences, &bootstrap](double confidence) {
    return bootstrap.interval(differences.values, confidence);
  };
  if (std::ranges::count(differences.values, 0.0) == std::ssize(differences.values)) {
    comparison.verdict = Verdict::equal;
  }
  return test;
}

}  // namespace

Comparisons compare_accuracy(const std::vector<Measurement>& measurements,
                             const std::string& stage) {
  const Variants variants = collect_variants(measurements, stage);
  std::vector<Differences> all;
  for (const Variant& b : variants.rows) {
    for (const Variant& a : variants.rows) {
      if (&a == &b) break;  // every pair once, the earlier row first
      if (!comparable(*a.first, *b.first)) continue;
      for (const auto& [metric, unit] : variants.metrics) {
        if (a.metrics.contains(metric) || b.metrics.contains(metric)) {
          all.push_back(differences_of(a, b, metric, unit));
        }
      }
    }
  }
  std::vector<Differences> pooled = pooled_over_views(all);
  std::ranges::move(pooled, std::back_inserter(all));

  const double level = Comparisons{}.level;
  Bootstraps bootstraps(resamples_for(all.size(), level));
  std::vector<ComparisonTest> tests;
  for (const Differences& differences : all) {
    tests.push_back(test_differences(differences, bootstraps));
  }
  return decide(std::move(tests));
}

}  // namespace occlab
