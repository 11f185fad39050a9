#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "harness/claims/claim_file.h"
#include "harness/claims/estimates.h"

namespace occlab {

enum class ClaimVerdict { value, ordering, not_reproduced, untestable };

/// "reproduced in value", "reproduced as an ordering", "not reproduced", "not testable here".
std::string_view to_string(ClaimVerdict verdict);
/// Throws InputError for any other text.
ClaimVerdict parse_verdict(std::string_view text, const std::string& where);
/// Value or ordering.
bool is_reproduced(ClaimVerdict verdict);

enum class CaseOutcome {
  holds,         ///< the whole corrected interval is between the bounds
  contradicted,  ///< it is wholly outside of them
  unresolved,    ///< neither
  untestable,
};
std::string_view to_string(CaseOutcome outcome);

/// The evidence for one case of a claim: of its statement, of its published value, or of both.
struct CaseEvidence {
  std::string label;
  std::string reason;  ///< of `untestable`
  // The statement, where the claim has one.
  CaseOutcome outcome = CaseOutcome::untestable;
  std::string quantity;
  std::string accepted;  ///< "> 1", "0.8 to 1.25"
  std::optional<ClaimEstimate> estimate;
  std::optional<Interval> interval;  ///< at the confidence at which the claim was judged
  // The published value, where the claim has one.
  std::string value_quantity;
  std::optional<double> published;
  std::optional<ClaimEstimate> value;
  std::optional<Interval> value_interval;  ///< 95%
  bool in_value = false;
  std::string value_remark;  ///< why not: "too uncertain to tell"
};

struct JudgedClaim {
  const Claim* claim = nullptr;
  ClaimVerdict verdict = ClaimVerdict::untestable;
  std::string reason;  ///< of `untestable`
  std::vector<CaseEvidence> cases;
  std::optional<double> adjusted_p;  ///< Holm's over all claims, where it was tested

  /// How many cases hold, or where there is no statement have the published value.
  std::size_t holding() const;
};

/// All claims of a file, judged together.
struct JudgedClaims {
  std::vector<JudgedClaim> all;
  std::size_t family = 0;  ///< how many statements were tested
  double level = 0.05;
};

/// A statement holds where all its cases do: its p-value is the largest of theirs
/// (intersection-union test, Berger 1982), those of all claims are corrected after Holm (1979), and
/// it holds where Holm's procedure rejects its opposite. So with probability `level` at most is any
/// false statement of the file called reproduced. Each interval has the confidence at which the
/// claim was judged, and is within the bounds exactly where the case holds. An equivalence or a
/// range holds where both its bounds are rejected (two one-sided tests, Schuirmann 1987).
///
/// A published value is reproduced where it lies within the 95% interval of what was measured, or
/// no farther from it than the claim's tolerance, and the interval is narrow enough to tell: its
/// half width is at most the claim's precision. These are not corrected: wider intervals would
/// accept more.
///
/// A claim that misses the measurements of one case is not testable, unless another case
/// already fails.
JudgedClaims judge_claims(const ClaimFile& file, ClaimEstimator& estimator);

}  // namespace occlab
