// Where the wall time of a run goes, with a planted clock.

#include "harness/work_clock.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace occlab {
namespace {

struct WorkClockTest : testing::Test {
  double now = 50.0;
  WorkClock clock{[this] { return now; }};
  void pass(double seconds) { now += seconds; }
};

TEST_F(WorkClockTest, InnerWorkDoesNotCountForTheOuter) {
  pass(1.0);
  const int answer = clock.in(measuring_work, [&] {
    pass(10.0);
    clock.in(storing_work, [&] {
      pass(2.0);
      clock.in(rendering_work, [&] { pass(30.0); });
      pass(0.5);
    });
    pass(5.0);
    return 42;
  });
  EXPECT_EQ(answer, 42);
  clock.in(timing_work, [&] { pass(20.0); });
  clock.in(tracing_work, [&] { pass(25.0); });
  pass(0.25);
  const nlohmann::json report = clock.report();
  EXPECT_DOUBLE_EQ(report["seconds"][measuring_work], 15.0);
  EXPECT_DOUBLE_EQ(report["seconds"][storing_work], 2.5);
  EXPECT_DOUBLE_EQ(report["seconds"][rendering_work], 30.0);
  EXPECT_DOUBLE_EQ(report["seconds"]["other"], 1.25);
  EXPECT_DOUBLE_EQ(report["total_seconds"], 93.75);
  EXPECT_DOUBLE_EQ(report["overhead_seconds"], 3.75) << "storing and what has no name";
  EXPECT_DOUBLE_EQ(report["overhead_share"], 3.75 / 93.75);
  EXPECT_EQ(
      overhead_sentence(report),
      "of 93.8 s, 4.0% were neither rendering, tracing, measuring nor timing: measuring 15.0 s, "
      "other 1.2 s, rendering 30.0 s, storing 2.5 s, timing 20.0 s, tracing 25.0 s");
}

TEST_F(WorkClockTest, WorkThatThrowsEnds) {
  EXPECT_THROW(clock.in(rendering_work,
                        [&] {
                          pass(3.0);
                          throw std::runtime_error("broken");
                        }),
               std::runtime_error);
  pass(1.0);
  EXPECT_DOUBLE_EQ(clock.report()["seconds"][rendering_work], 3.0);
  EXPECT_DOUBLE_EQ(clock.report()["overhead_seconds"], 1.0);
}

TEST_F(WorkClockTest, NoTimeIsNoShare) {
  EXPECT_DOUBLE_EQ(clock.report()["overhead_share"], 0.0);
  EXPECT_DOUBLE_EQ(clock.report()["total_seconds"], 0.0);
}

}  // namespace
}  // namespace occlab
