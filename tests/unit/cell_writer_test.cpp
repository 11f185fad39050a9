#include "harness/cell_writer.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "renderers/scene/error.h"
#include "renderers/scene/parallel.h"
#include "renderers/scene/temporary_folder.h"
#include "tests/unit/small_cells.h"

namespace occlab {
namespace {

class CellWriterTest : public testing::TestWithParam<int> {
 protected:
  void SetUp() override { set_thread_count(GetParam()); }
  void TearDown() override { set_thread_count(0); }

  TemporaryFolder folder_;
  CellStore store_{folder_.path()};
};

TEST_P(CellWriterTest, AllIsStoredOnceItReturns) {
  CellWriter writer(store_);
  for (int number = 0; number < 20; ++number) {
    writer.write(numbered_key(number), small_layers(), {}, {{"number", number}});
    // One thread is not two: nothing is left to be done beside.
    if (GetParam() == 1) {
      EXPECT_TRUE(store_.has(numbered_key(number))) << number;
    }
  }
  writer.flush();
  for (int number = 0; number < 20; ++number) {
    EXPECT_TRUE(store_.has(numbered_key(number))) << number;
  }
}

TEST_P(CellWriterTest, WhatCannotBeStoredIsSaid) {
  CellWriter writer(store_);
  const auto store_where_a_file_is = [&] {
    writer.write(numbered_key(0), small_layers(), {}, {});
    writer.flush();
  };
  std::filesystem::remove_all(folder_.path() / "cells");
  std::ofstream(folder_.path() / "cells") << "no folder";
  EXPECT_THROW(store_where_a_file_is(), DeviceError);
}

INSTANTIATE_TEST_SUITE_P(Threads, CellWriterTest, testing::Values(1, 2));

}  // namespace
}  // namespace occlab
