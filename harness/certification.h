#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "harness/config.h"
#include "harness/measure.h"
#include "harness/measurements.h"
#include "harness/tables.h"

namespace occlab {

// A reference is certified where it is known much better than the methods are wrong: where the
// half-width of its own 95% interval is at most a tolerance (0.1) of the smallest error that it has
// to judge. Both are of the whole frame, in mean luminances of the reference: 1.96 times the root
// of the mean variance of its pixels (and channels, as `rmse` has them), and the smallest `rmse` of
// all methods, parameters and stages, which has the reference's variance subtracted.

/// What an experiment's measurements say of its reference.
struct Certification {
  std::string method;  ///< of the reference
  double tolerance = 0.0;
  long rays_per_pixel = 0;      ///< traced; 0 where the method has no rays
  long max_rays_per_pixel = 0;  ///< the budget
  std::optional<double> half_width;
  std::optional<double> smallest_error;
  std::string smallest;  ///< whose error that is, "s3ho, samples 32, filtered"
  std::string reason;    ///< why there is no share, empty where there is one

  /// The half-width in smallest errors; none: it is not known that there is an error at all.
  std::optional<double> share() const;
  bool certified() const { return share() && *share() <= tolerance; }
  /// More rays are allowed and may help.
  bool open() const { return half_width && !certified() && rays_per_pixel < max_rays_per_pixel; }
  /// One line for the tables, run.json and the terminal.
  std::string verdict() const;
};

/// Metrics `reference_interval` (the half-width; without a value where the method states no
/// variance), `reference_tolerance`, `reference_rays_per_pixel` and
/// `reference_max_rays_per_pixel`. Throws InputError where the reference is not finite.
std::vector<Measurement> reference_rows(const MeasuredCell& reference, const Layers& layers,
                                        const ReferenceSettings& settings,
                                        const Measurement& identity);

/// From measure_cells() and reference_rows(). Nothing without a reference.
std::optional<Certification> certify(const std::vector<Measurement>& measurements);

/// The rows that certify() needs, of the first seed of each group only and of no other metric: to
/// decide on more rays before everything is measured.
std::vector<Measurement> quick_errors(const std::vector<MeasuredCell>& cells,
                                      const Layers& reference, const Measurement& identity,
                                      const ReadLayers& read);

/// How many more rays a pixel are to be traced: what the share asks for as the interval narrows
/// with the root of their number, in whole multiples of `step`, at most three times those there are
/// and what the budget leaves.
/// Without a share, as many as there are already. 0 where `certification` is not open().
long more_rays(const Certification& certification, long step);

/// As run.json has it: `certified`, `verdict` and what they come of; unknown numbers are null.
nlohmann::json to_json(const Certification& certification);

/// One row: rays, interval, smallest error, share and verdict. Empty without a reference.
Table reference_table(const std::vector<Measurement>& measurements);

}  // namespace occlab
