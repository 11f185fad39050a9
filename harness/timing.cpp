#include "harness/timing.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <map>
#include <memory>

#include "harness/cells.h"
#include "harness/machine_facts.h"
#include "harness/measurement_facts.h"
#include "harness/run_facts.h"
#include "harness/timing_loop.h"
#include "harness/timing_rows.h"
#include "harness/timing_stage.h"
#include "renderers/scene/error.h"
#include "renderers/scene/interrupt.h"
#include "renderers/scene/parallel.h"

namespace occlab {
namespace {

struct Variant {
  TimedCell cell;
  TimingStage* stage = nullptr;
  std::unique_ptr<OcclusionMethod> method;
  Measurement facts;
};

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// What of a cell's facts the axes of the experiment are.
Measurement facts_of_cell(const Experiment& experiment, const TimedCell& timed,
                          std::size_t triangles, const Measurement& shared) {
  Measurement facts = shared;
  facts.method = timed.cell.method;
  facts.resolution = fmt::format("{}x{}", timed.resolution.width, timed.resolution.height);
  facts.parameters = named_parameters(timed.cell.parameters);
  if (!experiment.timing->triangles.empty()) {
    facts.parameters.emplace_back(triangles_axis, fmt::format("{}", triangles));
  }
  if (!experiment.timing->threads.empty()) {
    facts.parameters.emplace_back(threads_axis, fmt::format("{}", timed.threads));
  }
  return facts;
}

std::optional<double> place_on(const std::string& axis, const Variant& variant) {
  const TimedCell& timed = variant.cell;
  if (axis == resolution_axis) return double(timed.resolution.width) * timed.resolution.height;
  if (axis == triangles_axis) return double(variant.stage->triangles());
  if (axis == threads_axis) return double(timed.threads);
  const ParameterValue& value = timed.cell.parameters.value(axis);
  if (const long* whole = std::get_if<long>(&value)) return double(*whole);
  if (const double* real = std::get_if<double>(&value)) return *real;
  return std::nullopt;  // words have no place on a scale
}

/// Timing one workbench.
class Session {
 public:
  Session(const Experiment& experiment, Workbench& bench, const std::vector<TimedCell>& cells,
          Measurement shared)
      : experiment_(experiment),
        calibration_(calibrate_clock(bench.frame().programs, bench.device().software)) {
    fmt::print(stderr, "timing: {}\n", calibration_.verdict);
    shared.clock = to_string(calibration_.clock);
    for (const TimedCell& cell : cells) add(bench, cell, shared);
    time();
    describe_machine(bench);
  }

  std::vector<TimedSeries> series() const {
    std::vector<TimedSeries> result;
    for (std::size_t i = 0; i < variants_.size(); ++i) {
      const Variant& variant = variants_[i];
      TimedSeries one{
          variant.facts, loop_.tasks[i], loop_.tasks[baseline_of(variant)], loop_.rejection, {}};
      for (const std::string& axis : variant.cell.axes) {
        const std::optional<double> place = place_on(axis, variant);
        if (place) one.axes.emplace_back(axis, *place);
      }
      result.push_back(std::move(one));
    }
    return result;
  }

  const nlohmann::json& context() const { return context_; }

  std::vector<std::string> notes() const {
    std::vector<std::string> notes = {
        calibration_.verdict,
        fmt::format("{} rasteriser: {}, {}; {}; threads that rasterise {}, that compute {}; load "
                    "{:.2f} before "
                    "and {:.2f} after",
                    context_.at("rasteriser").get<std::string>(),
                    context_.at("device").get<std::string>(),
                    context_.at("driver").get<std::string>(), context_.at("cpu").get<std::string>(),
                    context_.at("rasteriser_threads").get<int>(), thread_count(), load_before_,
                    load_after_)};
    for (const auto& [name, value] : experiment_.timing->baseline_at) {
      notes.push_back(fmt::format("ratios are to {} with {} = {}, whatever the row's own is",
                                  experiment_.timing->baseline, name, to_string(value)));
    }
    std::ranges::move(loop_notes(loop_, limits()), std::back_inserter(notes));
    return notes;
  }

 private:
  /// The scene as it is may also be asked for by the number of its triangles; then it is timed
  /// once.
  void add(Workbench& bench, const TimedCell& cell, const Measurement& shared) {
    auto& stage = stages_[cell.triangles];
    if (!stage) stage = std::make_unique<TimingStage>(bench, cell.triangles);
    Measurement facts = facts_of_cell(experiment_, cell, stage->triangles(), shared);
    const std::string key = facts_key(facts_of(facts));
    const auto known = std::ranges::find_if(variants_, [&](const Variant& variant) {
      return facts_key(facts_of(variant.facts)) == key;
    });
    if (known == variants_.end()) {
      variants_.push_back({cell, stage.get(), find_method(cell.cell.method).make(), facts});
    } else if (known->cell.triangles == 0 || cell.triangles == 0) {
      std::ranges::copy(cell.axes, std::back_inserter(known->cell.axes));
    } else {
      throw InputError(fmt::format(
          "{}: key 'timing.triangles': {} and {} both come to {}; accepted are 1, 4, 9, 16, ... "
          "times the scene's own {}",
          experiment_.file.string(), known->cell.triangles, cell.triangles, stage->triangles(),
          bench.scene().triangle_count()));
    }
  }

  TimingLimits limits() const {
    return {experiment_.timing->repetitions, experiment_.timing->budget_seconds};
  }

  /// The baseline's cell of the group, or the one that differs from it as `baseline_at` says.
  std::size_t baseline_of(const Variant& variant) const {
    const auto is_baseline = [&](const Variant& other) {
      return other.cell.cell.method == experiment_.timing->baseline;
    };
    auto baseline = std::ranges::find_if(variants_, [&](const Variant& other) {
      return other.cell.cell.group == variant.cell.cell.group && is_baseline(other);
    });
    if (experiment_.timing->baseline_at.empty()) return std::size_t(baseline - variants_.begin());
    ParameterSet wanted = baseline->cell.cell.parameters;
    for (const auto& [name, value] : experiment_.timing->baseline_at) wanted.set(name, value);
    baseline = std::ranges::find_if(variants_, [&](const Variant& other) {
      return is_baseline(other) && other.cell.cell.parameters.to_string() == wanted.to_string() &&
             other.cell.resolution == variant.cell.resolution &&
             other.cell.triangles == variant.cell.triangles;
    });
    return std::size_t(baseline - variants_.begin());
  }

  void time() {
    std::vector<TimingTask> tasks;
    for (Variant& variant : variants_) {
      tasks.push_back({baseline_of(variant), [&] {
                         throw_if_interrupted();
                         return variant.stage->run(*variant.method, variant.cell.cell.parameters,
                                                   variant.cell.resolution, calibration_.clock);
                       }});
    }
    load_before_ = load_average();
    loop_ = run_timing_loop(tasks, limits(), seconds_now, [](int repetition, double width) {
      fmt::print(stderr, "timing: repetition {}, widest interval of a ratio {:.1f}%\n", repetition,
                 100.0 * width);
    });
    load_after_ = load_average();
  }

  void describe_machine(const Workbench& bench) {
    context_ = {
        {"clock", to_string(calibration_.clock)},
        {"calibration", calibration_.verdict},
        {"device", bench.device().renderer},
        {"driver", bench.device().version},
        {"rasteriser", bench.device().software ? "software" : "hardware"},
        {"rasteriser_threads", rasteriser_threads()},
        {"cpu", cpu_model()},
        {"threads", thread_count()},
        {"load_before", load_before_},
        {"load_after", load_after_},
        {"repetitions", loop_.repetitions},
        {"seconds", loop_.seconds},
        {"widest_interval", loop_.widest_interval},
        {"stopped_because", loop_.within ? "every interval is within 2%" : "the budget ended"},
        {"drift_last_over_first_third", loop_.drift},
        {"rejected_passes", loop_.rejected_passes},
        {"rejection", loop_.rejection},
        {"overrun_frames", loop_.overrun_frames},
        {"largest_overrun", loop_.largest_overrun}};
  }

  const Experiment& experiment_;
  ClockCalibration calibration_;
  std::map<long, std::unique_ptr<TimingStage>> stages_;  ///< by the triangles asked for
  std::vector<Variant> variants_;
  LoopResult loop_;
  double load_before_ = 0.0;
  double load_after_ = 0.0;
  nlohmann::json context_;
};

/// `notes` are those of the sessions; what is to be said of the exponents comes after them.
TimingResult make_result(const Experiment& experiment, const std::vector<TimedSeries>& series,
                         nlohmann::json context, std::vector<std::string> notes) {
  TimingResult result{{}, std::move(context)};
  for (const TimedSeries& one : series) {
    std::ranges::move(time_rows(one), std::back_inserter(result.measurements));
  }
  if (experiment.timing->one_by_one) {
    Measurement shared = series.front().facts;
    shared.resolution.clear();
    shared.parameters.clear();
    Exponents exponents = fit_exponents(series, shared);
    std::ranges::move(exponents.rows, std::back_inserter(result.measurements));
    std::ranges::move(exponents.notes, std::back_inserter(notes));
  }
  result.context["notes"] = std::move(notes);
  return result;
}

/// llvmpipe looks at this when its device is opened.
void set_rasteriser_threads(int threads) {
  setenv("LP_NUM_THREADS", std::to_string(threads).c_str(), 1);
}

Workbench open_bench(const Experiment& experiment, const std::string& device) {
  return {{.scene = experiment.scene.source,
           .view = experiment.scene.view,
           .width = experiment.scene.width,
           .height = experiment.scene.height,
           .probe = experiment.probe},
          device};
}

void check_threads(const Experiment& experiment, const Workbench& bench, int threads) {
  if (!bench.device().software) {
    throw InputError(fmt::format("{}: key 'timing.threads': {} has no threads to choose",
                                 experiment.file.string(), bench.device().renderer));
  }
  if (rasteriser_threads() != threads) {
    throw DeviceError(fmt::format("device {}: {} threads were asked for and {} rasterise",
                                  bench.device().id, threads, rasteriser_threads()));
  }
}

}  // namespace

void require_own_threads(const Experiment& experiment) {
  if (!experiment.timing || experiment.timing->threads.empty()) return;
  throw InputError(fmt::format("{}: key 'timing.threads': accepted by 'occlab time' only",
                               experiment.file.string()));
}

TimingResult time_methods(const Experiment& experiment, Workbench& bench,
                          const Measurement& shared) {
  require_own_threads(experiment);
  const Session session(experiment, bench, plan_timing(experiment, methods()), shared);
  return make_result(experiment, session.series(), session.context(), session.notes());
}

TimingResult time_experiment(const Experiment& experiment, const std::string& device,
                             const std::function<void(const Workbench&)>& described) {
  if (experiment.timing->threads.empty()) {
    Workbench bench = open_bench(experiment, device);
    described(bench);
    return time_methods(experiment, bench, shared_facts(experiment, bench));
  }
  std::map<int, std::vector<TimedCell>> by_threads;
  for (TimedCell& cell : plan_timing(experiment, methods())) {
    const int threads = cell.threads;
    by_threads[threads].push_back(std::move(cell));
  }
  std::vector<TimedSeries> series;
  std::vector<std::string> notes;
  nlohmann::json sessions = nlohmann::json::array();
  for (const auto& [threads, cells] : by_threads) {
    set_rasteriser_threads(threads);
    Workbench bench = open_bench(experiment, device);
    check_threads(experiment, bench, threads);
    described(bench);
    const Session session(experiment, bench, cells, shared_facts(experiment, bench));
    std::ranges::move(session.series(), std::back_inserter(series));
    for (const std::string& note : session.notes()) {
      notes.push_back(fmt::format("threads = {}: {}", threads, note));
    }
    sessions.push_back(session.context());
  }
  notes.emplace_back("Different numbers of threads were timed one after the other, not paired");
  return make_result(experiment, series, {{"sessions", std::move(sessions)}}, std::move(notes));
}

}  // namespace occlab
