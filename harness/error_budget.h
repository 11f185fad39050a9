#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "harness/config.h"
#include "harness/measure.h"
#include "harness/store.h"
#include "harness/workbench.h"

namespace occlab {

// Why a method is wrong. With R the reference, T the method with traced visibility and D with the
// march of its own (through the depth buffer, several layers of it or several cameras'), both
// converged over their directions and not filtered, X the method's image and F the same filtered:
//
//     F - R  =  (T - R)       +  (D - T)    +  (X - D)   +  (F - X)
//     total  =  representation + visibility + sampling   + filter
//
// T and D depend neither on the samples nor on the filter: one budget cell serves all runs that
// differ in those only, and all methods in it share the directions.

/// A method as the budget has it: its cells that differ in samples and filter only.
struct BudgetVariant {
  std::string name;     ///< "ssbn"; "ssbn_2" where the same method comes again
  PlannedCell planned;  ///< the first of its cells
};

/// Whether a cell marches (whatever it marches through), with a method that also runs on the CPU.
bool has_budget(const PlannedCell& cell);

/// Variants that share the march.
struct BudgetCell {
  std::vector<BudgetVariant> variants;
};

/// Of the test cells whose method has a representation and which march through the depth buffer.
std::vector<BudgetCell> plan_budget(const std::vector<PlannedCell>& cells);

/// `bench`: bench_key() of cells.h.
CellKey budget_key(CellKey bench, const BudgetCell& cell, const BudgetSettings& settings);

/// Layers `VARIANT_traced` and `VARIANT_depth` (T and D, RGB), and of every failure class
/// (methods/failure_classes.h) `CLASS_occlusion` and `CLASS_radiance`. `facts` gets what each run
/// reached: VARIANT_depth_standard_error, _directions, _reached, ..., classes_standard_error.
Layers render_budget(Workbench& bench, const BudgetCell& cell, const BudgetSettings& settings,
                     Metadata& facts);

/// What measuring a budget reads beside the images.
struct StoredBudget {
  const BudgetCell& cell;
  std::string id;
  Layers layers;
  Metadata facts;
};

/// The variant that is the budget of a cell; nullptr if there is none.
const BudgetVariant* find_variant(const BudgetCell& budget, const PlannedCell& cell);

/// The parts by name in the order of the sum; `filter` only where there is a filtered image.
struct BudgetPart {
  std::string name;
  const Image* minuend;
  const Image* subtrahend;
};
std::vector<BudgetPart> budget_parts(const Layers& budget, const BudgetVariant& variant,
                                     const Image& reference, const Layers& cell);

/// The parts of every group of `cells` (the whole plan, the reference first) that the budget is of,
/// over the seeds, before and after the filter; and the failure classes of the budget's march.
///
/// Metrics, in mean luminances of the reference: `budget_rms.PART` (of the pixels, noise of the
/// reference and of the converged runs not taken off), `budget_mean.PART` (signed), and
/// `budget_share.PART`, the part's share of the mean squared error: <part total> / <total total>.
/// Means and shares of the parts add up to those of `total` exactly. `budget_floor` is the RMS of
/// the noise that R, T and D leave in the parts. Of classes, as a method `march`:
/// `failure_pixels.CLASS` (share of surface pixels whose k_A it changes by over .01),
/// `failure_mean.CLASS` and `failure_rms.CLASS` (of k_A, positive where light leaks in),
/// `failure_share.CLASS` (of the mean squared visibility error of the radiance) and
/// `failure_floor` (standard error of the classes' sum, k_A).
std::vector<Measurement> measure_budget(const StoredBudget& budget,
                                        const std::vector<MeasuredCell>& cells,
                                        const Measurement& identity, const ReadLayers& read);

}  // namespace occlab
