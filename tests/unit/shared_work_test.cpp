#include "harness/shared_work.h"

#include <gtest/gtest.h>

#include <chrono>
#include <set>
#include <thread>

#include "harness/cell_writer.h"
#include "renderers/scene/error.h"
#include "renderers/scene/temporary_folder.h"
#include "tests/unit/small_cells.h"

namespace occlab {
namespace {

/// A folder of results, and cells that are made at once and stored when the test says so.
class SharedWorkTest : public testing::Test {
 protected:
  std::vector<WorkItem> items(int count) {
    std::vector<WorkItem> items;
    for (int number = 0; number < count; ++number) {
      items.push_back(
          {numbered_key(number), "a cell", 1.0, [this, number] { made_.insert(number); }});
    }
    return items;
  }
  void store_what_was_made() {
    for (const int number : made_) store_.write(numbered_key(number), small_layers(), {});
  }
  static void no_warning(const std::string& warning) { FAIL() << warning; }
  /// Whether another process that wants a cell would be told that somebody is at it.
  bool taken(int number) const {
    return WorkLocks::taken(folder_.path(), numbered_key(number).hash()).value();
  }

  TemporaryFolder folder_;
  CellStore store_{folder_.path()};
  std::set<int> made_;
};

TEST_F(SharedWorkTest, ACellIsLockedUntilItIsStored) {
  SharedWork work(
      store_, items(3),
      WorkOptions{.flush = [this] { store_what_was_made(); }, .shard = {}, .cell_seconds = {}},
      no_warning);
  EXPECT_EQ(work.make_missing(), 3u);
  EXPECT_EQ(work.finished(), 0u) << "made, and still to be written";
  for (int number = 0; number < 3; ++number) EXPECT_TRUE(taken(number)) << number;

  work.settle();
  EXPECT_EQ(work.finished(), 3u);
  for (int number = 0; number < 3; ++number) EXPECT_FALSE(taken(number)) << number;
}

TEST_F(SharedWorkTest, LocksDoNotGrowWithTheWork) {
  // The writer has stored a cell once so many others came after it.
  const int count = int(CellWriter::most_waiting) + 5;
  SharedWork work(store_, items(count),
                  WorkOptions{.flush = [] {}, .shard = {}, .cell_seconds = {}}, no_warning);
  work.make_missing();
  int locked = 0;
  for (int number = 0; number < count; ++number) locked += taken(number) ? 1 : 0;
  EXPECT_EQ(locked, int(CellWriter::most_waiting));
  EXPECT_FALSE(taken(4));
  EXPECT_TRUE(taken(5));
}

TEST_F(SharedWorkTest, WhatWasMadeIsStoredWhenACellTakesTooLong) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto flush = [this] {
    store_what_was_made();
    std::fputs(store_.has(numbered_key(1)) ? "stored: 1\n" : "lost: 1\n", stderr);
  };
  const WorkItem hanging{numbered_key(2), "one that hangs", 1.0,
                         [] { std::this_thread::sleep_for(std::chrono::minutes(1)); }};
  const auto make_three = [&] {
    std::vector<WorkItem> three = items(2);
    three.push_back(hanging);
    const WorkOptions options{.flush = flush, .shard = {}, .cell_seconds = 0.3};
    SharedWork(store_, std::move(three), options, no_warning).make_missing();
  };
  EXPECT_EXIT(make_three(), testing::ExitedWithCode(exit_device_failed),
              "stored: 1\n(.|\n)*one that hangs: not finished within 0.3 s");
}

}  // namespace
}  // namespace occlab
