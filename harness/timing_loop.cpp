#include "harness/timing_loop.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>

#include "harness/statistics.h"
#include "harness/timing_statistics.h"

namespace occlab {
namespace {

constexpr double not_believed = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t fewest_ratios = 3;  // that say anything of their median

/// The clocks' own grain: a sum of passes may exceed its frame by so much without a contradiction.
constexpr double grain = 1e-3;

void shuffle(std::vector<std::size_t>& order, PortableRandom& random) {
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.index(i)]);
}

/// A random order in which a baseline and all that is compared with it are neighbours: the less
/// time between them, the less a busy machine changes meanwhile.
std::vector<std::size_t> random_order(const std::vector<TimingTask>& tasks,
                                      PortableRandom& random) {
  std::map<std::size_t, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < tasks.size(); ++i) groups[tasks[i].baseline].push_back(i);
  std::vector<std::size_t> baselines;
  for (auto& [baseline, members] : groups) {
    shuffle(members, random);
    baselines.push_back(baseline);
  }
  shuffle(baselines, random);
  std::vector<std::size_t> order;
  for (const std::size_t baseline : baselines) {
    order.insert(order.end(), groups[baseline].begin(), groups[baseline].end());
  }
  return order;
}

/// A pass that some repetition did not have, or had twice, still has one value a repetition.
void record(TaskTimes& task, std::string_view pass, std::size_t repetition, double ms) {
  auto found = std::ranges::find(task.passes, pass, &PassSeries::pass);
  if (found == task.passes.end()) {
    task.passes.push_back({std::string(pass), {}});
    found = std::prev(task.passes.end());
  }
  const bool again = found->ms.size() == repetition + 1;
  found->ms.resize(repetition + 1, not_believed);
  found->ms.back() = again ? found->ms.back() + ms : ms;
}

/// The frame's passes, the frame, and the rest, which is not known where a pass is not believed or
/// the passes took longer than the frame.
void record_frame(LoopResult& result, TaskTimes& task, const FrameTimes& frame,
                  std::size_t repetition) {
  double sum = 0.0;
  for (const auto& [pass, time] : frame.passes) {
    ++result.passes;
    if (!time.ms) {
      if (result.rejected_passes++ == 0) result.rejection = time.rejected;
    }
    const double ms = time.ms.value_or(not_believed);
    record(task, pass, repetition, ms);
    sum += ms;
  }
  ++result.frames;
  const double rest = frame.wall_ms - sum;  // NaN where a pass is not believed
  const double overrun = -rest / frame.wall_ms;
  const bool contradiction = overrun > grain;
  if (contradiction) {
    ++result.overrun_frames;
    result.largest_overrun = std::max(result.largest_overrun, overrun);
  }
  record(task, frame_pass, repetition, frame.wall_ms);
  record(task, rest_pass, repetition, contradiction ? not_believed : rest < 0.0 ? 0.0 : rest);
}

const std::vector<double>& judged_pass(const TaskTimes& task, const TaskTimes& baseline) {
  const bool both = task.find("occlusion") && baseline.find("occlusion");
  return *task.find(both ? std::string_view("occlusion") : frame_pass);
}

double interval_width(const TaskTimes& task, const TaskTimes& baseline) {
  const std::vector<double> ratios =
      paired_ratios_of(judged_pass(task, baseline), judged_pass(baseline, task));
  if (ratios.size() < fewest_ratios) return std::numeric_limits<double>::infinity();
  const Interval interval = interpolated_median_interval(ratios);
  return (interval.high - interval.low) / median(ratios);
}

double drift_of(const std::vector<TaskTimes>& tasks) {
  std::vector<double> ratios;
  for (const TaskTimes& task : tasks) {
    const std::vector<double>& frames = *task.find(frame_pass);
    const std::size_t third = std::max<std::size_t>(1, frames.size() / 3);
    ratios.push_back(median(std::span(frames).last(third)) /
                     median(std::span(frames).first(third)));
  }
  return median(ratios);
}

}  // namespace

const std::vector<double>* TaskTimes::find(std::string_view pass) const {
  const auto found = std::ranges::find(passes, pass, &PassSeries::pass);
  return found == passes.end() ? nullptr : &found->ms;
}

std::vector<double> paired_ratios_of(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const double ratio = a[i] / b[i];
    if (std::isfinite(ratio)) ratios.push_back(ratio);
  }
  return ratios;
}

std::vector<double> believed(const std::vector<double>& values) {
  std::vector<double> result;
  std::ranges::copy_if(values, std::back_inserter(result), [](double v) { return !std::isnan(v); });
  return result;
}

LoopResult run_timing_loop(const std::vector<TimingTask>& tasks, const TimingLimits& limits,
                           const std::function<double()>& seconds,
                           const std::function<void(int, double)>& after_repetition) {
  LoopResult result;
  result.tasks.resize(tasks.size());
  if (tasks.empty()) return result;
  for (const TimingTask& task : tasks) task.run();

  PortableRandom random(1);
  const double start = seconds();
  do {
    for (const std::size_t index : random_order(tasks, random)) {
      record_frame(result, result.tasks[index], tasks[index].run(),
                   std::size_t(result.repetitions));
    }
    ++result.repetitions;
    result.seconds = seconds() - start;
    result.widest_interval = 0.0;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      if (tasks[i].baseline == i) continue;
      result.widest_interval = std::max(
          result.widest_interval, interval_width(result.tasks[i], result.tasks[tasks[i].baseline]));
    }
    result.within = result.widest_interval <= wanted_interval_width;
    after_repetition(result.repetitions, result.widest_interval);
  } while (result.repetitions < limits.repetitions ||
           (!result.within && result.seconds < limits.budget_seconds));
  result.drift = drift_of(result.tasks);
  return result;
}

}  // namespace occlab
