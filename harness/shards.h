#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "harness/config.h"
#include "harness/error_budget.h"

namespace occlab {

/// One of the parts into which a run's work is split.
struct Shard {
  std::size_t index = 0;  ///< from 0; the command line counts from 1
  std::size_t count = 1;
};

inline constexpr std::size_t most_shards = 1'000'000;

/// "2/8" is the second of eight; I from 1 to N. Throws InputError "--shard TEXT: ...".
Shard parse_shard(const std::string& text);
std::string to_string(const Shard& shard);

/// The shard of each item, 0 to `count` - 1, from the costs and their order alone, so that every
/// process comes to the same split whatever is already finished. Items that are large for a shard
/// go to the least loaded one, largest first; the others fill the shards up in their order, so that
/// neighbours, which share scenes and shaders, stay together. Costs are positive.
std::vector<std::size_t> share_out(const std::vector<double>& costs, std::size_t count);

/// Roughly the seconds that a cell takes on two cores of a software rasteriser. Only ratios matter.
double estimated_seconds(const PlannedCell& cell, int width, int height);
/// The same of an error budget's cell.
double estimated_seconds(const BudgetCell& cell, const BudgetSettings& settings, int width,
                         int height);

}  // namespace occlab
