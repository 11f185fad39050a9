#include "harness/shards.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <numeric>

#include "renderers/methods/pass_constants.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

// About what gallery takes at 1280x720 on two cores of an AMD EPYC, llvmpipe and Embree: shares
// need no more than the proportions.
constexpr double seconds_per_cell = 0.02;           ///< G-buffer, sample set, files
constexpr double seconds_per_pixel = 0.6e-6;        ///< filter and EXR
constexpr double seconds_per_march_point = 1.8e-9;  ///< of one direction at one pixel
constexpr double seconds_per_ray = 1.4e-8;
/// What an error of 0.02 of a converged run takes, both runs and all variants of one march.
constexpr double converged_directions = 1024.0;
constexpr double converged_tolerance = 0.02;

/// Larger than this share of a shard, an item is placed on its own.
constexpr double large_share = 0.125;

/// The whole text as a number; 0 where it is none.
std::size_t whole_number(std::string_view text) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? value : 0;
}

double integer_or(const ParameterSet& parameters, const char* name, double otherwise) {
  return parameters.has(name) ? double(parameters.integer(name)) : otherwise;
}

}  // namespace

Shard parse_shard(const std::string& text) {
  const std::size_t slash = text.find('/');
  if (slash != std::string::npos) {
    const std::size_t number = whole_number(std::string_view(text).substr(0, slash));
    const std::size_t count = whole_number(std::string_view(text).substr(slash + 1));
    if (number >= 1 && number <= count && count <= most_shards) return {number - 1, count};
  }
  throw InputError(fmt::format(
      "--shard {}: not a shard; accepted: I/N with I from 1 to N and N at most {}, such as 2/8",
      text, most_shards));
}

std::string to_string(const Shard& shard) {
  return fmt::format("{}/{}", shard.index + 1, shard.count);
}

std::vector<std::size_t> share_out(const std::vector<double>& costs, std::size_t count) {
  assert(count > 0);
  assert(std::ranges::all_of(costs, [](double cost) { return cost > 0.0; }));
  std::vector<std::size_t> shards(costs.size(), 0);
  std::vector<double> loads(count, 0.0);
  const double whole = std::accumulate(costs.begin(), costs.end(), 0.0);
  const double large = large_share * whole / double(count);

  std::vector<std::size_t> order(costs.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](auto a, auto b) { return costs[a] > costs[b]; });
  double rest = whole;
  for (const std::size_t item : order) {
    if (costs[item] < large) break;
    const auto least = std::size_t(std::ranges::min_element(loads) - loads.begin());
    shards[item] = least;
    loads[least] += costs[item];
    rest -= costs[item];
  }

  // The level to which the small items fill all shards that are below it.
  std::vector<double> sorted = loads;
  std::ranges::sort(sorted);
  double level = 0.0;
  double below = 0.0;
  for (std::size_t n = 1; n <= count; ++n) {
    below += sorted[n - 1];
    level = (rest + below) / double(n);
    if (n == count || level <= sorted[n]) break;
  }
  std::size_t shard = 0;
  for (std::size_t item = 0; item < costs.size(); ++item) {
    if (costs[item] >= large) continue;
    while (shard + 1 < count && loads[shard] + 0.5 * costs[item] > level) ++shard;
    shards[item] = shard;
    loads[shard] += costs[item];
  }
  return shards;
}

double estimated_seconds(const PlannedCell& cell, int width, int height) {
  const double pixels = double(width) * double(height);
  const ParameterSet& parameters = cell.parameters;
  const double samples = integer_or(parameters, "samples", 0.0);
  const bool traced = parameters.has("visibility") && traces(parameters);
  const double rays = integer_or(parameters, "rays_per_pixel", 0.0) + (traced ? samples : 0.0);
  return seconds_per_cell +
         pixels * (seconds_per_pixel + rays * seconds_per_ray +
                   samples * integer_or(parameters, "steps", 1.0) * seconds_per_march_point);
}

double estimated_seconds(const BudgetCell& cell, const BudgetSettings& settings, int width,
                         int height) {
  const double pixels = double(width) * double(height);
  const double directions = converged_directions * converged_tolerance / settings.tolerance;
  const double seconds = pixels * directions * seconds_per_ray * double(2 + cell.variants.size());
  // Two converged runs and the classes, each at most a little longer than its budget.
  return seconds_per_cell + std::min(seconds, 3.0 * settings.budget_seconds);
}

}  // namespace occlab
