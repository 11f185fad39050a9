#include "harness/verify/cycles_verdicts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "harness/statistics.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr double accepted_difference = 0.005;

std::string channel_name(const RendererComparison& comparison, int channel) {
  if (comparison.z.channels() == 1) return "";
  return fmt::format(" of {}", std::vector{"red", "green", "blue"}[std::size_t(channel)]);
}

std::string percent(const BlockDifference& block) {
  return fmt::format("{:+.3f}% +- {:.3f}%", 100.0 * block.difference, 100.0 * block.error);
}

Check block_check(const RendererComparison& comparison, const std::string& name) {
  if (comparison.blocks.empty()) {
    throw InputError(
        fmt::format("verify cycles: no 64x64 block has {} pixels away from silhouettes; render "
                    "more pixels",
                    min_block_pixels));
  }
  const BlockDifference& worst =
      *std::ranges::max_element(comparison.blocks, {}, &BlockDifference::limit);
  const auto count = comparison.blocks.size() / std::size_t(comparison.z.channels());
  Check check = checked({.subject = "cycles",
                         .name = name,
                         .quantity = "worst 64x64 block: |ours / Cycles - 1| + its error",
                         .measured = worst.limit(),
                         .expected = 0.0,
                         .bound = accepted_difference,
                         .rule = "0.5%, at the far end of the block's 95% interval",
                         .detail = {}});
  const bool unresolved = !check.passes && std::abs(worst.difference) - worst.error <= check.bound;
  check.detail =
      fmt::format("{}{}{}, block at ({}, {}), {} pixels; {} blocks, {} left out with fewer than {}",
                  unresolved ? "could not resolve 0.5%, give more samples: " : "", percent(worst),
                  channel_name(comparison, worst.channel), worst.x, worst.y, worst.pixels, count,
                  comparison.blocks_left_out, min_block_pixels);
  return check;
}

Check mean_check(const RendererComparison& comparison, const std::string& name) {
  return checked({.subject = "cycles",
                  .name = name,
                  .quantity = "whole picture: |ours / Cycles - 1| + its error",
                  .measured = comparison.whole.limit(),
                  .expected = 0.0,
                  .bound = accepted_difference,
                  .rule = "0.5%, at the far end of the 95% interval",
                  .detail = fmt::format("{}{}", percent(comparison.whole),
                                        channel_name(comparison, comparison.whole.channel))});
}

Check share_check(const RendererComparison& comparison, const std::string& name) {
  const double expected = 2.0 * normal_cdf(-3.0);
  const double error = std::sqrt(expected * (1.0 - expected) / comparison.independent_pixels);
  Check check{.subject = "cycles",
              .name = name,
              .quantity = "share of pixels beyond 3 sigma",
              .measured = comparison.share_beyond_3_sigma,
              .expected = expected,
              .bound = -normal_quantile(share_false_alarms) * error,
              .rule = "no more than noise gives; false alarms 1e-6",
              .detail = {}};
  check.passes = check.measured <= check.expected + check.bound;  // fewer are no fault
  const auto worst =
      std::ranges::max_element(comparison.z.values(), {}, [](float z) { return std::abs(z); }) -
      comparison.z.values().begin();
  const auto pixel = worst / comparison.z.channels();
  check.detail = fmt::format("{} pixels; largest z {:+.1f} at ({}, {})", comparison.pixels,
                             comparison.z.values()[std::size_t(worst)],
                             pixel % comparison.z.width(), pixel / comparison.z.width());
  return check;
}

}  // namespace

Checks judge_comparison(const RendererComparison& comparison, const std::string& name) {
  return {block_check(comparison, name), share_check(comparison, name),
          mean_check(comparison, name)};
}

}  // namespace occlab
