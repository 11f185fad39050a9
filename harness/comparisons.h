#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "harness/measurement_facts.h"
#include "harness/measurements.h"

namespace occlab {

enum class Verdict {
  less,        ///< a < b
  greater,     ///< a > b
  equal,       ///< the same number for every seed: the images do not differ in it
  unresolved,  ///< the corrected test does not tell them apart
  unknown,     ///< could not be tested: `reason` says why
};

/// Two methods under the same conditions, compared in one quantity over the same seeds.
struct Comparison {
  std::string quantity;
  std::string unit;
  std::string stage;
  Facts facts;  ///< those of both without the method
  std::string a;
  std::string b;
  std::string row_of_a;  ///< facts_key of the rows compared; "" where several views are pooled
  std::string row_of_b;
  bool ratio = false;           ///< value is a / b, and 1 is equal; otherwise a - b, and 0 is
  std::optional<double> value;  ///< mean over the seeds
  /// Lower and upper come together, may be infinite, and exclude equality exactly where the verdict
  /// is less or greater.
  std::optional<double> lower;
  std::optional<double> upper;
  double confidence = 0.0;           ///< of the interval: that at which Holm's procedure judged it
  std::optional<double> adjusted_p;  ///< Holm's; none where the verdict is `unknown`
  long n = 0;                        ///< seeds
  Verdict verdict = Verdict::unknown;
  std::string reason;  ///< of `unknown`; empty otherwise
};

/// A family of comparisons: any of its `less` and `greater` is wrong with probability `level` at
/// most, all of them together (Holm 1979).
struct Comparisons {
  std::vector<Comparison> all;
  std::size_t tested = 0;  ///< how many of them had a p-value: the size of the family
  double level = 0.05;
  /// The least p-value that any of the tested could have had. Where it exceeds level / tested,
  /// these are too few seeds for so many comparisons, and none can be resolved.
  double smallest_p = 0.0;
};

/// Every pair of methods in every accuracy metric at one stage, seed by seed, with the paired
/// bootstrap of paired_bootstrap.h. Where the same two methods were compared in several views or
/// scenes (closeups are not views of their own), one more comparison pools them over views and
/// seeds. The family is all of these together. Throws InputError for a row that is there twice.
Comparisons compare_accuracy(const std::vector<Measurement>& measurements,
                             const std::string& stage);

/// Every pair of methods in noise (a ratio) and bias_squared (a difference) at one stage, from the
/// rows `noise_ratio.A/B` and `bias_squared_difference.A/B` and their Student intervals.
Comparisons compare_noise(const std::vector<Measurement>& measurements, const std::string& stage);

/// Every row `METRIC_ratio.A/B`, in order, as one family.
Comparisons compare_ratios(const std::vector<Measurement>& measurements);

/// Which direction is better; nothing for metrics that occlab does not know.
std::optional<bool> lower_is_better(const std::string& metric);

/// The better of the two methods; "" where the verdict or the metric does not say.
std::string better_method(const Comparison& comparison);

/// Which rows of a table beat every other row they were compared with.
class Winners {
 public:
  explicit Winners(const Comparisons& comparisons);
  /// `row`: its facts_key. False where it was compared with nothing or could not be everywhere.
  /// `bias` is judged by its square.
  bool wins(const std::string& row, const std::string& metric) const;

 private:
  struct Score {
    int compared = 0;
    int won = 0;
  };
  std::unordered_map<std::string, Score> scores_;
};

}  // namespace occlab
