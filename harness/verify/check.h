#pragma once

#include <string>
#include <vector>

namespace occlab {

/// One thing `occlab verify` measured against what it must be.
struct Check {
  std::string subject;   ///< what is verified: "reference", "passes", "metrics", "cycles"
  std::string name;      ///< the case: "infinite wall, kappa = .25"
  std::string quantity;  ///< "k_A", "E_r", "largest |GPU - CPU|"
  double measured = 0.0;
  double expected = 0.0;
  double bound = 0.0;  ///< |measured - expected| that is accepted
  std::string rule;    ///< where the bound comes from: "5.2 sigma, Sidak over 41 tests at 1e-6"
  bool passes = false;
  std::string detail;  ///< the worst pixel, the folder of the images; "" if there is nothing to say
};

using Checks = std::vector<Check>;

/// passes = |measured - expected| <= bound; false where anything is NaN.
inline Check checked(Check check) {
  const double error = check.measured > check.expected ? check.measured - check.expected
                                                       : check.expected - check.measured;
  check.passes = error <= check.bound;
  return check;
}

}  // namespace occlab
