#pragma once

#include <optional>
#include <string>
#include <vector>

#include "harness/report/cells.h"
#include "renderers/scene/image.h"

namespace occlab::report {

struct NamedMap {
  std::string name;
  std::string kind;  ///< "signed" or "positive"
  Image map;         ///< one channel
  std::string note;  ///< "" or what is to be said of it
};

/// Rec.709 luminance of an RGB image over `mean_luminance`.
Image relative_luminance(const Image& rgb, double mean_luminance);

/// Over a group's seeds, of luminances in mean luminances of the reference: `noise` and
/// `noise_unfiltered`, the standard deviation of a pixel over the seeds, and, with a reference,
/// `bias`, the mean over the seeds (after the filter) minus the reference. Empty below two seeds.
std::vector<NamedMap> seed_maps(std::vector<Cell>& cells, const Group& group,
                                const Image* reference, double mean_luminance);

/// The parts of the group's error (error_budget.h) in luminance, which add up to its first seed's
/// image minus the reference: `budget_representation`, and so on. `layers` is that first seed.
std::vector<NamedMap> budget_maps(const NamedTexts& budget_facts, const Layers& budget,
                                  const Group& group, const Layers& layers, const Image& reference,
                                  double mean_luminance);

/// Ambient occlusion by the depth buffer minus traced, by failure class (failure_classes.h).
std::vector<NamedMap> failure_maps(const Layers& budget);

}  // namespace occlab::report
