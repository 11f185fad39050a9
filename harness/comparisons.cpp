#include "harness/comparisons.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "harness/comparison_tests.h"
#include "harness/metrics/metrics.h"

namespace occlab {
namespace {

/// Whether all cells of `part` are among those of `whole`.
bool holds_cells(const Measurement& whole, const Measurement& part) {
  return std::ranges::all_of(part.cells, [&](const std::string& cell) {
    return std::ranges::find(whole.cells, cell) != whole.cells.end();
  });
}

/// The rows that compare two methods, by the facts of the first one, quantity and second method.
class ComparedRows {
 public:
  ComparedRows(const std::vector<Measurement>& measurements, const std::string& stage) {
    for (const Measurement& m : measurements) {
      const std::optional<ComparedMetric> metric = compared_metric(m.metric);
      if (m.stage != stage || m.seed != "all" || !metric) continue;
      rows_[key(m, metric->quantity, metric->b)].push_back(&m);
    }
  }

  /// nullptr if there is none.
  const Measurement* find(const Measurement& a, const Measurement& b,
                          const std::string& quantity) const {
    const auto rows = rows_.find(key(a, quantity, b.method));
    if (rows == rows_.end()) return nullptr;
    // Rows do not hold the parameters that only b has, but its cells.
    const auto row = std::ranges::find_if(rows->second, [&](const Measurement* m) {
      return holds_cells(*m, a) && holds_cells(*m, b);
    });
    return row == rows->second.end() ? nullptr : *row;
  }

 private:
  static std::string key(const Measurement& a, const std::string& quantity, const std::string& b) {
    Facts facts = facts_of(a);
    facts.emplace_back("quantity", quantity);
    facts.emplace_back("b", b);
    return facts_key(facts);
  }
  std::unordered_map<std::string, std::vector<const Measurement*>> rows_;
};

}  // namespace

Comparisons compare_noise(const std::vector<Measurement>& measurements, const std::string& stage) {
  std::vector<const Measurement*> variants;
  for (const Measurement& m : measurements) {
    if (m.stage == stage && m.seed == "all" && m.metric == "noise") variants.push_back(&m);
  }
  const ComparedRows rows(measurements, stage);
  std::vector<ComparisonTest> tests;
  const auto add = [&](const Measurement& a, const Measurement& b, const std::string& quantity,
                       bool ratio) {
    Comparison comparison = new_comparison(a, b);
    comparison.quantity = quantity;
    comparison.ratio = ratio;
    if (const Measurement* const row = rows.find(a, b, quantity)) {
      tests.push_back(test_estimate(std::move(comparison), *row));
    } else {
      comparison.reason = "not measured";
      tests.push_back({std::move(comparison), std::nullopt, 0.0, {}});
    }
  };
  // Every pair once, the later row first: so the rows of pairs are written.
  for (std::size_t a = 0; a < variants.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      if (!comparable(*variants[a], *variants[b])) continue;
      add(*variants[a], *variants[b], "noise", true);
      add(*variants[a], *variants[b], "bias_squared", false);
    }
  }
  return decide(std::move(tests));
}

Comparisons compare_ratios(const std::vector<Measurement>& measurements) {
  std::vector<ComparisonTest> tests;
  for (const Measurement& m : measurements) {
    const std::optional<ComparedMetric> metric = compared_metric(m.metric);
    if (m.seed != "all" || !metric || !metric->ratio) continue;
    Comparison comparison;
    comparison.quantity = metric->quantity;
    comparison.stage = m.stage;
    comparison.facts = facts_of(m);
    std::erase_if(comparison.facts, [](const auto& f) { return f.first == "method"; });
    comparison.a = metric->a;
    comparison.b = metric->b;
    comparison.ratio = true;
    tests.push_back(test_estimate(std::move(comparison), m));
  }
  return decide(std::move(tests));
}

std::optional<bool> lower_is_better(const std::string& metric) {
  for (const char* name : {"noise", "bias", "bias_squared", "mse"}) {
    if (metric == name) return true;
  }
  const auto found = std::ranges::find(metrics(), metric, &MetricInfo::name);
  if (found == metrics().end()) return std::nullopt;
  return found->lower_is_better;
}

std::string better_method(const Comparison& comparison) {
  const std::optional<bool> lower = lower_is_better(comparison.quantity);
  const bool less = comparison.verdict == Verdict::less;
  if (!lower || (!less && comparison.verdict != Verdict::greater)) return "";
  return less == *lower ? comparison.a : comparison.b;
}

Winners::Winners(const Comparisons& comparisons) {
  for (const Comparison& comparison : comparisons.all) {
    if (comparison.row_of_a.empty()) continue;  // pooled: of no single row
    const std::string better = better_method(comparison);
    for (const auto& [row, method] : {std::pair(&comparison.row_of_a, &comparison.a),
                                      std::pair(&comparison.row_of_b, &comparison.b)}) {
      Score& score = scores_[*row + comparison.quantity];
      ++score.compared;
      score.won += !better.empty() && better == *method ? 1 : 0;
    }
  }
}

bool Winners::wins(const std::string& row, const std::string& metric) const {
  const auto score = scores_.find(row + (metric == "bias" ? "bias_squared" : metric));
  return score != scores_.end() && score->second.won == score->second.compared;
}

}  // namespace occlab
