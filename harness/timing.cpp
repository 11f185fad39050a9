#include "harness/timing.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <numeric>

#include "harness/cells.h"
#include "harness/statistics.h"
#include "renderers/gl/timer.h"
#include "renderers/scene/interrupt.h"
#include "renderers/scene/parallel.h"

namespace occlab {
namespace {

constexpr double wanted_interval_width = 0.02;

/// One entry a repetition; the whole frame is the pass "frame".
using PassTimes = std::vector<std::pair<std::string, std::vector<double>>>;

std::vector<double>& times_of(PassTimes& passes, std::string_view pass) {
  const auto found = std::ranges::find(passes, pass, &PassTimes::value_type::first);
  if (found != passes.end()) return found->second;
  return passes.emplace_back(std::string(pass), std::vector<double>()).second;
}

const std::vector<double>* find_times(const PassTimes& passes, std::string_view pass) {
  const auto found = std::ranges::find(passes, pass, &PassTimes::value_type::first);
  return found == passes.end() ? nullptr : &found->second;
}

struct Variant {
  PlannedCell cell;
  std::unique_ptr<OcclusionMethod> method;
  PassTimes passes;
  const Variant* baseline = nullptr;
};

std::vector<Variant> make_variants(const Experiment& experiment) {
  std::vector<Variant> variants;
  for (PlannedCell& cell : plan_timing(experiment, methods())) {
    auto method = find_method(cell.method).make();
    variants.push_back({std::move(cell), std::move(method), {}, nullptr});
  }
  for (Variant& variant : variants) {
    const auto baseline = std::ranges::find_if(variants, [&](const Variant& other) {
      return other.cell.group == variant.cell.group &&
             other.cell.method == experiment.timing->baseline;
    });
    variant.baseline = &*baseline;
  }
  return variants;
}

/// One frame; "frame" is its wall time, so that what lies between the passes shows.
void run_once(Variant& variant, Frame& frame, Clock clock) {
  const PassClock plain = frame.clock;
  frame.clock = [&](std::string_view pass, const std::function<void()>& run) {
    times_of(variant.passes, pass).push_back(time_ms(clock, run));
  };
  const double frame_ms =
      time_ms(Clock::wall, [&] { variant.method->render(frame, variant.cell.parameters); });
  times_of(variant.passes, "frame").push_back(frame_ms);
  frame.clock = plain;
}

std::vector<std::size_t> random_order(std::size_t count, PortableRandom& random) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random.index(i)]);
  return order;
}

/// The widest 95% interval of an occlusion pass's ratio to its baseline, relative to the ratio.
double widest_interval(const std::vector<Variant>& variants) {
  double widest = 0.0;
  for (const Variant& variant : variants) {
    if (variant.baseline == &variant) continue;
    const auto& times = *find_times(variant.passes, "occlusion");
    const auto& baseline = *find_times(variant.baseline->passes, "occlusion");
    const Interval interval = median_ratio_interval(times, baseline);
    widest = std::max(widest, (interval.high - interval.low) / median_ratio(times, baseline));
  }
  return widest;
}

/// Median of the last third over that of the first, of all frames: 1 on a quiet machine.
double drift(const std::vector<Variant>& variants) {
  std::vector<double> ratios;
  for (const Variant& variant : variants) {
    const std::vector<double>& frames = *find_times(variant.passes, "frame");
    const std::size_t third = std::max<std::size_t>(1, frames.size() / 3);
    ratios.push_back(median(std::span(frames).last(third)) /
                     median(std::span(frames).first(third)));
  }
  return median(ratios);
}

std::string cpu_model() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

double load_average() {
  double load = -1.0;
  return getloadavg(&load, 1) == 1 ? load : -1.0;
}

void add_rows(const Variant& variant, const Measurement& identity,
              std::vector<Measurement>& measurements) {
  for (const auto& [pass, times] : variant.passes) {
    Measurement row = identity;
    row.method = variant.cell.method;
    row.parameters = named_parameters(variant.cell.parameters);
    row.seed = "all";
    row.metric = "time_ms." + pass;
    row.unit = "ms";
    const Quartiles summary = quartiles(times);
    row.value = summary.median;
    row.lower = summary.lower;
    row.upper = summary.upper;
    row.n = long(times.size());
    measurements.push_back(row);

    const std::vector<double>* baseline = find_times(variant.baseline->passes, pass);
    if (!baseline) continue;
    row.metric = "time_ratio." + pass;
    row.unit = "";
    const Interval interval = median_ratio_interval(times, *baseline);
    row.value = median_ratio(times, *baseline);
    row.lower = interval.low;
    row.upper = interval.high;
    measurements.push_back(row);
  }
}

}  // namespace

TimingResult time_methods(const Experiment& experiment, Workbench& bench,
                          const Measurement& identity) {
  const TimingSettings& settings = *experiment.timing;
  const ClockCalibration calibration = calibrate_clock(bench.frame().programs);
  fmt::print(stderr, "timing: {}\n", calibration.verdict);

  std::vector<Variant> variants = make_variants(experiment);
  const double load_before = load_average();
  for (Variant& variant : variants) {
    throw_if_interrupted();
    run_once(variant, bench.frame(), calibration.clock);
    variant.passes.clear();
  }

  PortableRandom random(1);
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  int repetitions = 0;
  double width = 1.0;
  while (repetitions < settings.repetitions ||
         (width > wanted_interval_width && seconds() < settings.budget_seconds)) {
    for (const std::size_t index : random_order(variants.size(), random)) {
      throw_if_interrupted();
      run_once(variants[index], bench.frame(), calibration.clock);
    }
    ++repetitions;
    width = widest_interval(variants);
    fmt::print(stderr, "timing: repetition {}, widest interval of a ratio {:.1f}%\n", repetitions,
               100.0 * width);
  }
  const std::string stop = width <= wanted_interval_width
                               ? "every interval is within 2%"
                               : fmt::format("the budget of {:g} s ended", settings.budget_seconds);

  TimingResult result;
  Measurement shared = identity;
  shared.clock = to_string(calibration.clock);
  for (const Variant& variant : variants) add_rows(variant, shared, result.measurements);
  result.context = {{"clock", to_string(calibration.clock)},
                    {"calibration", calibration.verdict},
                    {"device", bench.device().renderer},
                    {"driver", bench.device().version},
                    {"rasteriser", bench.device().software ? "software" : "hardware"},
                    {"cpu", cpu_model()},
                    {"threads", thread_count()},
                    {"load_before", load_before},
                    {"load_after", load_average()},
                    {"repetitions", repetitions},
                    {"seconds", seconds()},
                    {"widest_interval", width},
                    {"stopped_because", stop},
                    {"drift_last_over_first_third", drift(variants)}};
  return result;
}

}  // namespace occlab
