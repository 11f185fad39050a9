#include "harness/shards.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

std::vector<double> loads(const std::vector<double>& costs, std::size_t count) {
  const std::vector<std::size_t> shards = share_out(costs, count);
  std::vector<double> sums(count, 0.0);
  for (std::size_t i = 0; i < costs.size(); ++i) sums.at(shards[i]) += costs[i];
  return sums;
}

TEST(Shards, AreReadFromText) {
  EXPECT_EQ(parse_shard("2/8").index, 1u);
  EXPECT_EQ(parse_shard("2/8").count, 8u);
  EXPECT_EQ(to_string(parse_shard("8/8")), "8/8");
  for (const char* text : {"", "/", "0/8", "9/8", "1/0", "1", "1/", "/1", "1/2/3", "a/b", "-1/8",
                           "1/8 ", "+1/8", "1.5/8", "1/1000001", "99999999999999999999/1"}) {
    EXPECT_THROW(parse_shard(text), InputError) << text;
  }
}

TEST(Shards, TheWholeIsSplitAndOneShardHasAll) {
  const std::vector<double> costs = {3.0, 1.0, 4.0, 1.0, 5.0};
  EXPECT_EQ(share_out(costs, 1), std::vector<std::size_t>(5, 0));
  EXPECT_TRUE(share_out({}, 4).empty());
  const auto sums = loads(costs, 3);
  EXPECT_DOUBLE_EQ(std::accumulate(sums.begin(), sums.end(), 0.0), 14.0);
}

TEST(Shards, EqualCellsAreSplitEvenlyAndStayInTheirOrder) {
  const std::vector<double> costs(1000, 0.37);
  const std::vector<std::size_t> shards = share_out(costs, 7);
  EXPECT_TRUE(std::ranges::is_sorted(shards)) << "neighbours share scenes and shaders";
  for (std::size_t shard = 0; shard < 7; ++shard) {
    EXPECT_NEAR(double(std::ranges::count(shards, shard)), 1000.0 / 7.0, 1.0);
  }
}

TEST(Shards, ALargeItemHasAShardOfItsOwn) {
  std::vector<double> costs(20, 1.0);
  costs[0] = 20.0;  // a reference beside 20 cells
  const std::vector<std::size_t> shards = share_out(costs, 2);
  for (std::size_t i = 1; i < costs.size(); ++i) EXPECT_NE(shards[i], shards[0]);
}

/// No shard exceeds the best possible by more than a small item, or by a third where a few large
/// ones cannot be split better (the bound of largest-first: 4/3).
TEST(Shards, AreBalanced) {
  std::mt19937 random(5);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> costs(20 + random() % 400);
    for (double& cost : costs) {
      cost = 0.01 + double(random() % 1000) / 1000.0;
      if (random() % 50 == 0) cost *= 40.0;
    }
    const std::size_t count = 1 + random() % 16;
    const auto sums = loads(costs, count);
    const double mean = std::accumulate(costs.begin(), costs.end(), 0.0) / double(count);
    const double best = std::max(mean, *std::ranges::max_element(costs));
    EXPECT_LE(*std::ranges::max_element(sums), 4.0 / 3.0 * best + 1e-9) << trial;
    EXPECT_EQ(share_out(costs, count), share_out(costs, count));
  }
}

TEST(Shards, MoreShardsThanItemsLeaveSomeEmpty) {
  const auto sums = loads({1.0, 2.0, 3.0}, 10);
  EXPECT_EQ(std::ranges::count(sums, 0.0), 7);
  EXPECT_DOUBLE_EQ(*std::ranges::max_element(sums), 3.0);
}

}  // namespace
}  // namespace occlab
