// Timing with planted times and a planted clock: what is rejected, reconciled, stopped and stated.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "harness/statistics.h"
#include "harness/timing_loop.h"
#include "harness/timing_rows.h"
#include "renderers/gl/timer.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr std::int64_t ms = 1000000;  // nanoseconds

PassTime good(double milliseconds) { return {milliseconds, milliseconds, ""}; }
PassTime rejected(double wall) { return {std::nullopt, wall, "zero"}; }

std::string all_of(const std::vector<std::string>& notes) {
  std::string text;
  for (const std::string& note : notes) text += note + "\n";
  return text;
}
bool mentions(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(QueryReadings, OnlyPossibleOnesAreBelieved) {
  EXPECT_EQ(why_rejected({5 * ms}, 5.1), "");
  EXPECT_EQ(why_rejected({ms / 10}, 0.3), "") << "starting a short pass may take twice as long";
  EXPECT_EQ(why_rejected({1}, 9.9), "");
  EXPECT_TRUE(mentions(why_rejected({0}, 5.0), "0 ms for 5 ms of wall time: zero"));
  EXPECT_TRUE(mentions(why_rejected({0}, 1e-4), "zero"));
  EXPECT_TRUE(mentions(why_rejected({-3 * ms}, 5.0), "-3 ms for 5 ms of wall time: negative"));
  EXPECT_TRUE(mentions(why_rejected({std::numeric_limits<std::int64_t>::min()}, 5.0), "negative"));
  EXPECT_TRUE(mentions(why_rejected({std::numeric_limits<std::int64_t>::max()}, 5.0), "longer"));
  EXPECT_TRUE(mentions(why_rejected({5 * ms + 1}, 5.0), "longer than the wall time around it"));
  EXPECT_TRUE(mentions(why_rejected({ms}, std::nan("")), "longer")) << "no wall time, no belief";
  // What llvmpipe says.
  EXPECT_TRUE(mentions(why_rejected({800000}, 451.0), "0.8 ms for 451 ms of wall time: less than"));
  EXPECT_TRUE(mentions(why_rejected({ms, 0}, 5.0), "no counter"));
  EXPECT_TRUE(mentions(why_rejected({4000 * ms, 32}, 5000.0), "started again")) << "2^32 ns: 4.3 s";
  EXPECT_EQ(why_rejected({4000 * ms, 32}, 4200.0), "");
}

TEST(ClockCalibration, BelievesTheQueryOnlyWhereAllReadingsAgree) {
  const ClockComparison close{{98 * ms}, 100.0};
  const ClockCalibration believed = judge_clocks({close, {{95 * ms}, 100.0}, close}, false);
  EXPECT_EQ(believed.clock, Clock::gpu_query);
  EXPECT_DOUBLE_EQ(believed.query_ms, 95.0) << "the worst is what is shown";
  EXPECT_EQ(believed.verdict,
            "GL_TIME_ELAPSED says 95.00 ms for a pass of 100.00 ms of wall time: believed; times "
            "are by GL_TIME_ELAPSED");
  for (const QueryReading bad : {QueryReading{89 * ms}, QueryReading{101 * ms}, QueryReading{0},
                                 QueryReading{-ms}, QueryReading{98 * ms, 0}}) {
    const ClockCalibration calibration = judge_clocks({close, {bad, 100.0}, close}, false);
    EXPECT_EQ(calibration.clock, Clock::wall) << bad.nanoseconds;
    EXPECT_TRUE(mentions(calibration.verdict, "not believed; times are by wall clock"))
        << calibration.verdict;
  }
}

TEST(ClockCalibration, NeverBelievesTheQueryOfASoftwareRasteriser) {
  const ClockComparison close{{98 * ms}, 100.0};
  const ClockCalibration calibration = judge_clocks({close, close, close}, true);
  EXPECT_EQ(calibration.clock, Clock::wall);
  EXPECT_TRUE(mentions(calibration.verdict, "not believed of a software rasteriser; times are by"))
      << calibration.verdict;
}

/// Tasks that take planted times on a clock that they advance themselves.
struct FakeMachine {
  double now = 1000.0;  // seconds
  int runs = 0;

  TimingTask task(std::size_t baseline, std::function<FrameTimes(int run)> frame) {
    return {baseline, [this, frame, run = 0]() mutable {
              ++runs;
              FrameTimes times = frame(run++);
              now += times.wall_ms * 1e-3;
              return times;
            }};
  }
  LoopResult time(const std::vector<TimingTask>& tasks, const TimingLimits& limits) {
    return run_timing_loop(
        tasks, limits, [this] { return now; }, [](int, double) {});
  }
};

FrameTimes frame_of(double occlusion, double filter = 1.0) {
  return {{{"occlusion", good(occlusion)}, {"filter", good(filter)}}, occlusion + filter + 0.5};
}

/// Noise without chance, the same for all tasks: 1 % at most.
double wobble(int run) { return 1.0 + 0.01 * std::sin(2.4 * run); }

TEST(TimingLoop, EndsWhereEveryIntervalIsTight) {
  FakeMachine machine;
  const LoopResult result =
      machine.time({machine.task(0, [](int run) { return frame_of(100.0 * wobble(run)); }),
                    machine.task(0, [](int run) { return frame_of(150.0 * wobble(run)); })},
                   {7, 1e6});
  EXPECT_TRUE(result.within);
  EXPECT_EQ(result.repetitions, 7) << "not before the least number";
  EXPECT_EQ(machine.runs, 2 * (1 + 7)) << "the first frame of each warms up and does not count";
  EXPECT_LE(result.widest_interval, wanted_interval_width);
  const double total = machine.now - 1000.0;
  EXPECT_LT(result.seconds, total) << "without the warm-up";
  EXPECT_GT(result.seconds, 0.8 * total);
  EXPECT_TRUE(mentions(all_of(loop_notes(result, {7, 1e6})), "every interval is within 2%"));
}

TEST(TimingLoop, GoesOnUntilTheIntervalIsTight) {
  FakeMachine machine;
  // 10 % of noise at first, which the median outgrows.
  const LoopResult result = machine.time(
      {machine.task(0, [](int) { return frame_of(100.0); }),
       machine.task(0,
                    [](int run) { return frame_of(run < 12 ? 100.0 + 10.0 * (run % 3) : 120.0); })},
      {5, 1e6});
  EXPECT_TRUE(result.within);
  EXPECT_GT(result.repetitions, 12);
  EXPECT_LT(result.repetitions, 60);
}

TEST(TimingLoop, EndsWithTheBudgetAndSaysSo) {
  FakeMachine machine;
  const auto noisy = [](int run) { return frame_of(run % 2 ? 100.0 : 200.0); };
  const TimingLimits limits{7, 4.0};
  const LoopResult result = machine.time(
      {machine.task(0, [](int) { return frame_of(100.0); }), machine.task(0, noisy)}, limits);
  EXPECT_FALSE(result.within);
  EXPECT_GE(result.seconds, 4.0);
  EXPECT_LT(result.seconds, 4.0 + 0.4) << "no more than the repetition that was under way";
  EXPECT_TRUE(mentions(all_of(loop_notes(result, limits)), "the budget of 4 s was spent"));

  FakeMachine slow;
  const LoopResult least =
      slow.time({slow.task(0, [](int) { return frame_of(5000.0); })}, {7, 4.0});
  EXPECT_EQ(least.repetitions, 7) << "the least number comes before the budget";
}

TEST(TimingLoop, WhatIsComparedRunsTogether) {
  std::vector<std::size_t> order;
  FakeMachine machine;
  std::vector<TimingTask> tasks;
  for (std::size_t i = 0; i < 6; ++i) {
    tasks.push_back(machine.task(i % 3, [&order, i](int) {
      order.push_back(i);
      return frame_of(10.0);
    }));
  }
  machine.time(tasks, {40, 0.1});
  std::set<std::size_t> firsts;
  for (std::size_t at = 6; at < order.size(); at += 2) {
    EXPECT_EQ(order[at] % 3, order[at + 1] % 3);
    if (at % 6 == 0) firsts.insert(order[at]);
  }
  EXPECT_EQ(firsts.size(), 6u) << "groups and their members change places";
}

TEST(TimingLoop, OrderIsShuffledWithinARepetition) {
  std::vector<int> order;
  FakeMachine machine;
  std::vector<TimingTask> tasks;
  for (int i = 0; i < 4; ++i) {
    tasks.push_back(machine.task(0, [&order, i](int) {
      order.push_back(i);
      return frame_of(10.0);
    }));
  }
  machine.time(tasks, {40, 0.1});
  std::array<int, 4> first{};
  for (std::size_t r = 1; r <= 40; ++r) {
    std::set<int> once(order.begin() + std::ptrdiff_t(4 * r),
                       order.begin() + std::ptrdiff_t(4 * r + 4));
    EXPECT_EQ(once.size(), 4u) << "each once a repetition";
    ++first[std::size_t(order[4 * r])];
  }
  for (const int count : first) EXPECT_GT(count, 2);
}

TEST(TimingLoop, RestIsWhatLiesInNoPass) {
  FakeMachine machine;
  const LoopResult result =
      machine.time({machine.task(0, [](int) { return frame_of(7.0, 2.0); })}, {3, 0.1});
  EXPECT_NEAR(median(*result.tasks[0].find(frame_pass)), 9.5, 1e-12);
  EXPECT_NEAR(median(*result.tasks[0].find(rest_pass)), 0.5, 1e-12);
  EXPECT_EQ(result.overrun_frames, 0);
  EXPECT_FALSE(mentions(all_of(loop_notes(result, {3, 0.1})), "WARNING"));
}

TEST(TimingLoop, PassesLongerThanTheirFrameAreSaid) {
  FakeMachine machine;
  const LoopResult result = machine.time({machine.task(0,
                                                       [](int run) {
                                                         FrameTimes frame = frame_of(7.0, 2.0);
                                                         if (run == 2)
                                                           frame.wall_ms = 8.0;  // 9 ms of passes
                                                         return frame;
                                                       })},
                                         {4, 0.1});
  EXPECT_EQ(result.frames, 4);
  EXPECT_EQ(result.overrun_frames, 1);
  EXPECT_NEAR(result.largest_overrun, 9.0 / 8.0 - 1.0, 1e-12);
  EXPECT_TRUE(std::isnan((*result.tasks[0].find(rest_pass))[1])) << "not 0, not negative";
  EXPECT_TRUE(mentions(all_of(loop_notes(result, {4, 0.1})),
                       "WARNING: in 1 of 4 frames the passes together took longer than the frame "
                       "around them, by up to 12%"));
}

TEST(TimingLoop, RejectedTimesCountForNothing) {
  FakeMachine machine;
  const LoopResult result = machine.time({machine.task(0, [](int) { return frame_of(100.0); }),
                                          machine.task(0,
                                                       [](int run) {
                                                         FrameTimes frame = frame_of(150.0);
                                                         if (run % 4 == 3)
                                                           frame.passes[0].second = rejected(150.0);
                                                         return frame;
                                                       })},
                                         {9, 0.1});
  EXPECT_EQ(result.rejected_passes, 2);
  EXPECT_EQ(result.passes, 9 * 4);
  EXPECT_EQ(result.rejection, "zero");
  const std::vector<double>& times = *result.tasks[1].find("occlusion");
  ASSERT_EQ(times.size(), 9u);
  EXPECT_TRUE(std::isnan(times[2]) && std::isnan(times[6]));
  EXPECT_EQ(believed(times).size(), 7u);
  EXPECT_TRUE(std::isnan((*result.tasks[1].find(rest_pass))[2]));
  EXPECT_EQ(paired_ratios_of(times, *result.tasks[0].find("occlusion")),
            std::vector<double>(7, 1.5));
  EXPECT_TRUE(mentions(all_of(loop_notes(result, {9, 0.1})),
                       "WARNING: 2 of 36 times of passes were rejected; the first: zero"));
}

TEST(TimingLoop, NothingThatCanBeBelievedIsNoInterval) {
  FakeMachine machine;
  const LoopResult result =
      machine.time({machine.task(0, [](int) { return frame_of(100.0); }),
                    machine.task(0,
                                 [](int) {
                                   return FrameTimes{{{"occlusion", rejected(5.0)}}, 6.0};
                                 })},
                   {4, 1.0});
  EXPECT_TRUE(std::isinf(result.widest_interval));
  EXPECT_FALSE(result.within);
  EXPECT_GE(result.seconds, 1.0);
  const TimedSeries series{{}, result.tasks[1], result.tasks[0], result.rejection, {}};
  for (const Measurement& row : time_rows(series)) {
    if (row.metric.ends_with("occlusion")) {
      EXPECT_FALSE(row.value) << row.metric;
      EXPECT_TRUE(mentions(row.reason, "only 0 of ")) << row.reason;
      EXPECT_TRUE(mentions(row.reason, "zero")) << row.reason;
    } else if (row.metric.ends_with("frame")) {
      EXPECT_TRUE(row.value);
    }
  }
}

TEST(TimingLoop, DriftIsMeasuredAndSaid) {
  const auto drifting = [](double per_run) {
    FakeMachine machine;
    return machine.time(
        {machine.task(0, [=](int run) { return frame_of(100.0 * std::pow(1.0 + per_run, run)); })},
        {30, 0.1});
  };
  EXPECT_NEAR(drifting(0.0).drift, 1.0, 1e-12);
  // The middles of the first and last ten of thirty runs are twenty apart.
  EXPECT_NEAR(drifting(0.01).drift, std::pow(1.01, 20), 5e-3);
  const TimingLimits limits{30, 0.1};
  EXPECT_TRUE(
      mentions(all_of(loop_notes(drifting(0.01), limits)), "WARNING: the drift is beyond 5%"));
  EXPECT_TRUE(mentions(all_of(loop_notes(drifting(-0.01), limits)), "WARNING: the drift"));
  EXPECT_FALSE(mentions(all_of(loop_notes(drifting(0.001), limits)), "WARNING"));
}

}  // namespace
}  // namespace occlab
