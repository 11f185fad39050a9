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
#include "harness/timing_statistics.h"
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
  const ClockCalibration believed = judge_clocks({close, {{95 * ms}, 100.0}, close});
  EXPECT_EQ(believed.clock, Clock::gpu_query);
  EXPECT_DOUBLE_EQ(believed.query_ms, 95.0) << "the worst is what is shown";
  EXPECT_EQ(believed.verdict,
            "GL_TIME_ELAPSED says 95.00 ms for a pass of 100.00 ms of wall time: believed; times "
            "are by GL_TIME_ELAPSED");
  for (const QueryReading bad : {QueryReading{89 * ms}, QueryReading{101 * ms}, QueryReading{0},
                                 QueryReading{-ms}, QueryReading{98 * ms, 0}}) {
    const ClockCalibration calibration = judge_clocks({close, {bad, 100.0}, close});
    EXPECT_EQ(calibration.clock, Clock::wall) << bad.nanoseconds;
    EXPECT_TRUE(mentions(calibration.verdict, "not believed; times are by wall clock"))
        << calibration.verdict;
  }
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

TEST(TimeRows, MediansQuartilesAndRatios) {
  TaskTimes base;
  base.passes = {{"gbuffer", {1, 1, 1}},
                 {"occlusion", {10, 20, 40}},
                 {"frame", {12, 22, 42}},
                 {"rest", {1, 1, 1}}};
  TaskTimes slower = base;
  slower.passes[1].ms = {11, 24, 40};
  Measurement facts;
  facts.method = "s3ho";
  const std::vector<Measurement> rows = time_rows({facts, slower, base, "", {}});
  const auto find = [&](const std::string& metric) -> const Measurement* {
    const auto row = std::ranges::find(rows, metric, &Measurement::metric);
    return row == rows.end() ? nullptr : &*row;
  };
  EXPECT_DOUBLE_EQ(*find("time_ms.occlusion")->value, 24);
  EXPECT_DOUBLE_EQ(*find("time_ms.occlusion")->lower, 17.5);
  EXPECT_EQ(find("time_ms.occlusion")->unit, "ms");
  EXPECT_NEAR(*find("time_ratio.occlusion")->value, 1.1, 1e-12) << "pair by pair, not 24 / 20";
  EXPECT_NEAR(*find("time_ratio.occlusion")->lower, 1.0, 1e-12);
  EXPECT_NEAR(*find("time_ratio.occlusion")->upper, 1.2, 1e-12);
  EXPECT_EQ(find("time_ratio.occlusion")->n, 3);
  EXPECT_TRUE(find("time_ratio.frame"));
  EXPECT_FALSE(find("time_ratio.gbuffer"));
  EXPECT_FALSE(find("time_ratio.rest"));
  for (const Measurement& row : rows) EXPECT_EQ(row.seed, "all");
}

std::vector<double> repeated(double value, std::size_t count = 5) {
  return std::vector<double>(count, value);
}

TEST(PowerLaw, ExactLawsAreFound) {
  for (const double exponent : {-1.0, 0.0, 0.5, 1.0, 2.0}) {
    std::vector<RepeatedPoint> points;
    for (const double x : {128.0, 4.0, 32.0, 8.0}) {  // in any order
      points.push_back({x, repeated(3.0 * std::pow(x, exponent))});
    }
    const auto law = fit_power_law(points);
    ASSERT_TRUE(law);
    EXPECT_NEAR(law->exponent, exponent, 1e-12);
    EXPECT_EQ(law->points, 4);
    EXPECT_FALSE(law->curved);
    EXPECT_NEAR(law->interval->low, exponent, 1e-9);
    EXPECT_NEAR(law->interval->high, exponent, 1e-9);
  }
}

TEST(PowerLaw, ACommonFactorOfARepetitionCancels) {
  std::vector<RepeatedPoint> points;
  for (const double x : {1.0, 2.0, 4.0}) points.push_back({x, {x, 5.0 * x, 0.1 * x}});
  EXPECT_NEAR(fit_power_law(points)->exponent, 1.0, 1e-12);
  EXPECT_NEAR(fit_power_law(points)->interval->high, 1.0, 1e-9);
}

TEST(PowerLaw, OfAConstantPlusALawTheAsymptoticPart) {
  std::vector<RepeatedPoint> points;
  for (const double x : {1.0, 2.0, 4.0, 8.0, 16.0, 1e4, 2e4, 4e4}) {
    points.push_back({x, {}});
    for (int r = 0; r < 5; ++r) points.back().y.push_back((10.0 + x) * (1.0 + 1e-4 * r * (r - 2)));
  }
  const auto law = fit_power_law(points);
  EXPECT_EQ(law->points, 3);
  EXPECT_NEAR(law->exponent, 1.0, 1e-3);
  EXPECT_FALSE(law->curved);

  points.resize(5);  // bends to the last
  const auto bent = fit_power_law(points);
  EXPECT_EQ(bent->points, 3);
  EXPECT_TRUE(bent->curved);
  EXPECT_LT(bent->exponent, 0.6);
}

TEST(PowerLaw, MissingTimes) {
  std::vector<RepeatedPoint> points = {{1.0, {1.0, std::nan(""), 1.0}}, {2.0, {2.0, 9.0, 2.0}}};
  EXPECT_NEAR(fit_power_law(points)->exponent, 1.0, 1e-12) << "without the second repetition";
  points[1].y = {std::nan(""), 2.0, std::nan("")};
  EXPECT_FALSE(fit_power_law(points));
  points = {{1.0, {1.0}}, {2.0, {4.0}}};
  EXPECT_NEAR(fit_power_law(points)->exponent, 2.0, 1e-12);
  EXPECT_FALSE(fit_power_law(points)->interval) << "one repetition says nothing of its error";
}

TEST(PowerLaw, Refusals) {
  EXPECT_THROW(fit_power_law({{1.0, {1.0}}}), InputError);
  EXPECT_THROW(fit_power_law({{0.0, {1.0}}, {1.0, {1.0}}}), InputError);
  EXPECT_THROW(fit_power_law({{1.0, {1.0}}, {1.0, {1.0}}}), InputError);
  EXPECT_THROW(fit_power_law({{1.0, {0.0}}, {2.0, {1.0}}}), InputError);
  EXPECT_THROW(fit_power_law({{1.0, {1.0}}, {2.0, {1.0, 1.0}}}), InputError);
}

TEST(Exponents, OfEveryAxisMethodAndPass) {
  std::vector<TimedSeries> all;
  for (const char* method : {"ssao", "s3ho"}) {
    for (const double x : {8.0, 16.0, 32.0}) {
      TimedSeries series;
      series.facts.method = method;
      series.times.passes = {{"occlusion", repeated(method[1] == 's' ? x : x * x)},
                             {"frame", repeated(5.0)},
                             {"rest", repeated(1.0)}};
      series.axes = {{"samples", x}};
      if (x == 8.0) series.axes.emplace_back("steps", 2.0);
      all.push_back(series);
    }
  }
  const Exponents exponents = fit_exponents(all, {});
  const auto find = [&](const char* method, const std::string& metric) {
    const auto row = std::ranges::find_if(exponents.rows, [&](const Measurement& m) {
      return m.method == method && m.metric == metric;
    });
    return row == exponents.rows.end() ? Measurement() : *row;
  };
  EXPECT_NEAR(*find("ssao", "time_exponent.samples.occlusion").value, 1.0, 1e-9);
  EXPECT_NEAR(*find("s3ho", "time_exponent.samples.occlusion").value, 2.0, 1e-9);
  EXPECT_NEAR(*find("s3ho", "time_exponent.samples.frame").value, 0.0, 1e-9);
  EXPECT_EQ(find("ssao", "time_exponent.steps.occlusion").reason, "one point only");
  EXPECT_EQ(find("ssao", "time_exponent.samples.rest").metric, "") << "the rest is no work";
}

TEST(MedianInterval, ByHand) {
  // n = 6: from the smallest to the largest covers 1 - 2/64, the next 1 - 14/64.
  const std::vector<double> six = {6, 2, 4, 1, 5, 3};
  const double share = (62.0 / 64 - 0.95) / (12.0 / 64);
  const double weight = 5 * share / (1 + 4 * share);
  EXPECT_NEAR(interpolated_median_interval(six).low, 1 + weight, 1e-12);
  EXPECT_NEAR(interpolated_median_interval(six).high, 6 - weight, 1e-12);
  const Interval three = interpolated_median_interval(std::vector<double>{3, 1, 2});
  EXPECT_EQ(three.low, 1);
  EXPECT_EQ(three.high, 3);
  EXPECT_DOUBLE_EQ(three.confidence, 0.75);
  EXPECT_EQ(interpolated_median_interval(std::vector<double>{5}).confidence, 0.0);
  EXPECT_THROW(interpolated_median_interval({}), InputError);
  EXPECT_THROW(interpolated_median_interval(six, 1.0), InputError);
}

}  // namespace
}  // namespace occlab
