#include "harness/measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "harness/cells.h"
#include "harness/measure_references.h"
#include "harness/metrics/metrics.h"
#include "harness/metrics/noise_bias.h"
#include "harness/metrics/power_spectrum.h"

namespace occlab {
namespace {

constexpr double confidence = 0.95;

/// Metrics whose ratios between methods are tabulated.
constexpr std::array<std::string_view, 2> compared_metrics = {"rmse", "rgb_angle_shadow"};

struct Stage {
  const char* name;
  const char* layer;
};
constexpr std::array<Stage, 2> stages = {
    {{"unfiltered", "radiance_unfiltered"}, {"filtered", "radiance"}}};

/// The image of a stage: a method that did not filter has only the unfiltered one.
const Image* stage_image(const Layers& layers, const Stage& stage) {
  const bool filtered = layers.find("radiance_unfiltered") != nullptr;
  if (filtered) return &layers.at(stage.layer);
  return stage.layer == std::string_view("radiance") ? nullptr : &layers.at("radiance");
}

/// What one group of cells (seeds of one method and parameters) gave at one stage.
struct GroupStage {
  using ViewAndMetric = std::pair<std::string, std::string>;
  std::map<ViewAndMetric, std::vector<double>> values;  ///< one a seed
  std::map<ViewAndMetric, std::string> units;
  std::map<ViewAndMetric, std::string> reasons;  ///< why a seed has no value
  std::optional<NoiseBias> noise_bias;
  std::optional<NoiseSpectrum> spectrum;
};

struct Group {
  const PlannedCell* planned = nullptr;
  const Reference* reference = nullptr;
  std::vector<std::string> cells;
  std::map<std::string, GroupStage> stages;
};

/// Equal values of all parameters that both declare, seeds apart: the methods can be compared.
bool comparable(const ParameterSet& a, const ParameterSet& b) {
  return std::ranges::all_of(a.declared(), [&](const Parameter& parameter) {
    return parameter.name == "seed" || !b.has(parameter.name) ||
           a.value(parameter.name) == b.value(parameter.name);
  });
}

/// Forgets what no other group is compared with.
void keep_compared(Group& group) {
  const auto others = [](const auto& entry) {
    return std::ranges::find(compared_metrics, entry.first.second) == compared_metrics.end();
  };
  for (auto& [name, stage] : group.stages) {
    std::erase_if(stage.values, others);
    std::erase_if(stage.units, others);
    std::erase_if(stage.reasons, others);
    stage.spectrum.reset();
  }
}

class Measurer {
 public:
  explicit Measurer(const Measurement& identity) : identity_(identity) {}

  void add_seed(Group& group, const Stage& stage, const MeasuredCell& cell,
                const ReferenceImages& reference, const Image& image) {
    GroupStage& sums = group.stages[stage.name];
    for (const MetricValue& metric : reference.measure(image)) {
      const GroupStage::ViewAndMetric name(reference.view, metric.name);
      Measurement row = new_row(group, stage.name, name, metric.unit);
      row.seed = std::to_string(cell.planned.parameters.integer("seed"));
      row.cells = {cell.id};
      row.value = metric.value;
      row.reason = metric.reason;
      row.n = long(metric.pixels);
      rows_.push_back(std::move(row));
      sums.units[name] = metric.unit;
      if (metric.value) {
        sums.values[name].push_back(*metric.value);
      } else {
        sums.reasons[name] = metric.reason;
      }
    }
  }

  /// How much of the samples fell off the screen, a fact of the samples rather than of a stage.
  void add_off_screen(const Group& group, const MeasuredCell& cell, const Image& share,
                      const Image& mask) {
    double sum = 0.0;
    long pixels = 0;
    for (std::size_t p = 0; p < mask.pixel_count(); ++p) {
      if (mask.values()[p] <= 0.5f) continue;
      sum += double(share.values()[p]);
      ++pixels;
    }
    Measurement row = new_row(group, "", {identity_.view, "off_screen_samples"}, "1");
    row.seed = std::to_string(cell.planned.parameters.integer("seed"));
    row.cells = {cell.id};
    row.value = sum / double(pixels);
    row.n = pixels;
    rows_.push_back(std::move(row));
  }

  /// Mean over the seeds, Student's interval; missing as soon as one seed has no value.
  void add_means(const Group& group) {
    for (const auto& [stage, sums] : group.stages) {
      for (const auto& [name, unit] : sums.units) {
        Measurement row = new_row(group, stage, name, unit);
        row.cells = group.cells;
        const auto reason = sums.reasons.find(name);
        if (reason != sums.reasons.end()) {
          row.reason = reason->second;
        } else {
          const std::vector<double>& values = sums.values.at(name);
          row.value = mean(values);
          row.n = long(values.size());
          if (values.size() >= 2 && std::isfinite(*row.value)) {
            const double half = student_half_width(values, confidence);
            row.lower = *row.value - half;
            row.upper = *row.value + half;
          }
        }
        rows_.push_back(std::move(row));
      }
      if (sums.noise_bias) add_noise(group, stage, *sums.noise_bias);
    }
  }

  /// Ratios and differences of two groups of the same seeds.
  void add_comparisons(const Group& a, const Group& b) {
    for (const auto& [stage, sums] : a.stages) {
      const auto other = b.stages.find(stage);
      if (other == b.stages.end()) continue;
      add_noise_comparisons(a, b, stage, sums.noise_bias, other->second.noise_bias);
      for (const auto& [name, unit] : sums.units) {
        if (std::ranges::find(compared_metrics, name.second) == compared_metrics.end()) continue;
        add_estimate(a, b, stage, name, "ratio", "", metric_ratio(sums, other->second, name));
      }
    }
  }

  std::vector<Measurement> take() { return std::exchange(rows_, {}); }

 private:
  Measurement new_row(const Group& group, const std::string& stage,
                      const GroupStage::ViewAndMetric& name, const std::string& unit) const {
    Measurement row = identity_;
    row.view = name.first;
    row.method = group.planned->method;
    row.parameters = named_parameters(group.planned->parameters);
    row.seed = "all";
    row.stage = stage;
    row.metric = name.second;
    row.unit = unit;
    row.reference_cell = group.reference->cell;
    return row;
  }

  /// Geometric mean of the ratios seed by seed, Student's interval of its logarithm.
  static Estimate metric_ratio(const GroupStage& stage_of_a, const GroupStage& stage_of_b,
                               const GroupStage::ViewAndMetric& name) {
    Estimate estimate;
    std::vector<double> logarithms;
    for (const GroupStage* stage : {&stage_of_a, &stage_of_b}) {
      const auto reason = stage->reasons.find(name);
      if (reason != stage->reasons.end()) estimate.reason = reason->second;
      if (!stage->units.contains(name)) estimate.reason = "not measured";
    }
    if (!estimate.reason.empty()) return estimate;
    const std::vector<double>& a = stage_of_a.values.at(name);
    const std::vector<double>& b = stage_of_b.values.at(name);
    if (a.size() != b.size()) {
      estimate.reason = different_seeds(a.size(), b.size());
      return estimate;
    }
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (!(a[i] > 0.0) || !(b[i] > 0.0)) {
        estimate.reason = "a value is not positive";
        return estimate;
      }
      logarithms.push_back(std::log(a[i] / b[i]));
    }
    estimate.value = std::exp(mean(logarithms));
    if (logarithms.size() >= 2) {
      const double half = student_half_width(logarithms, confidence);
      estimate.interval =
          Interval{*estimate.value * std::exp(-half), *estimate.value * std::exp(half), confidence};
    }
    return estimate;
  }

  static Estimate scaled(Estimate estimate, double factor) {
    if (estimate.value) *estimate.value *= factor;
    if (estimate.interval) {
      estimate.interval->low *= factor;
      estimate.interval->high *= factor;
    }
    return estimate;
  }

  static std::string different_seeds(std::size_t a, std::size_t b) {
    return fmt::format("{} and {} seeds: only equal seeds make pairs", a, b);
  }

  void add_noise_comparisons(const Group& a, const Group& b, const std::string& stage,
                             const std::optional<NoiseBias>& of_a,
                             const std::optional<NoiseBias>& of_b) {
    if (!of_a || !of_b) return;
    Estimate ratio;
    Estimate difference;
    if (of_a->runs == of_b->runs) {
      // Each is in mean luminances of its own reference.
      ratio = scaled(noise_ratio(*of_a, *of_b, confidence),
                     of_a->mean_luminance / of_b->mean_luminance);
      if (a.reference == b.reference) {
        difference = bias_squared_difference(*of_a, *of_b, confidence);
      } else {
        difference.reason = "their references are not the same";
      }
    } else {
      ratio.reason = difference.reason =
          different_seeds(std::size_t(of_a->runs), std::size_t(of_b->runs));
    }
    add_estimate(a, b, stage, {identity_.view, "noise"}, "ratio", "", ratio);
    add_estimate(a, b, stage, {identity_.view, "bias_squared"}, "difference", "mean luminance^2",
                 difference);
  }

  void add_noise(const Group& group, const std::string& stage, const NoiseBias& noise_bias) {
    const auto add = [&](const std::string& name, const char* unit, const Estimate& estimate) {
      Measurement row = new_row(group, stage, {identity_.view, name}, unit);
      row.cells = group.cells;
      row.n = noise_bias.runs;
      fill(row, estimate);
      rows_.push_back(std::move(row));
    };
    add("noise", "mean luminance", noise_bias.noise);
    add("bias", "mean luminance", noise_bias.bias);
    add("bias_squared", "mean luminance^2", noise_bias.bias_squared);
    add("mse", "mean luminance^2", noise_bias.mse);
    const GroupStage& sums = group.stages.at(stage);
    if (!sums.spectrum) return;
    for (const NoiseSpectrum::Bin& bin : sums.spectrum->bins) {
      add(fmt::format("noise_spectrum.{}", bin.frequency), "mean luminance^2 per (cycle/pixel)^2",
          bin.power);
    }
  }

  void add_estimate(const Group& a, const Group& b, const std::string& stage,
                    const GroupStage::ViewAndMetric& name, const char* kind, const char* unit,
                    const Estimate& estimate) {
    const std::string metric =
        fmt::format("{}_{}.{}/{}", name.second, kind, a.planned->method, b.planned->method);
    Measurement row = new_row(a, stage, {name.first, metric}, unit);
    row.cells = a.cells;
    row.cells.insert(row.cells.end(), b.cells.begin(), b.cells.end());
    row.n = long(a.cells.size());
    fill(row, estimate);
    rows_.push_back(std::move(row));
  }

  static void fill(Measurement& row, const Estimate& estimate) {
    row.value = estimate.value;
    row.reason = estimate.reason;
    // A row without a value has no interval; the reason says why there is none.
    if (estimate.value && estimate.interval && std::isfinite(estimate.interval->low) &&
        std::isfinite(estimate.interval->high)) {
      row.lower = estimate.interval->low;
      row.upper = estimate.interval->high;
    }
  }

  Measurement identity_;
  std::vector<Measurement> rows_;
};

}  // namespace

std::vector<StageImage> stage_images(const Layers& layers) {
  std::vector<StageImage> images;
  for (const Stage& stage : stages) {
    if (const Image* image = stage_image(layers, stage)) images.push_back({stage.name, *image});
  }
  return images;
}

void measure_cells(const std::vector<MeasuredCell>& cells, const std::vector<Region>& regions,
                   const Measurement& identity, const ReadLayers& read,
                   const std::function<void(std::size_t)>& progress, const RowSink& sink) {
  if (cells.empty() || cells.front().planned.role != Role::reference) return;
  const std::vector<Reference> references =
      read_references(cells, regions, identity.view, read, progress);
  std::vector<PlannedCell> planned;
  for (const MeasuredCell& cell : cells) planned.push_back(cell.planned);
  Measurer measurer(identity);

  std::vector<Group> groups;
  std::size_t index = references.size();
  while (index < cells.size()) {
    const int id = cells[index].planned.group;
    Group group{
        &cells[index].planned, &references[reference_place(planned, cells[index].planned)], {}, {}};
    const std::vector<ReferenceImages>& images = group.reference->images;
    std::map<std::string, RunStatistics> runs;
    for (; index < cells.size() && cells[index].planned.group == id; ++index) {
      progress(index);
      const Layers layers = read(cells[index]);
      group.cells.push_back(cells[index].id);
      if (const Image* share = layers.find("off_screen")) {
        measurer.add_off_screen(group, cells[index], *share, images.front().mask);
      }
      for (const Stage& stage : stages) {
        const Image* image = stage_image(layers, stage);
        if (!image) continue;
        runs.try_emplace(stage.name, images.front().mask).first->second.add(*image);
        for (const ReferenceImages& reference : images) {
          measurer.add_seed(group, stage, cells[index], reference, *image);
        }
      }
    }
    const ReferenceImages& whole = images.front();
    for (const auto& [stage, statistics] : runs) {
      if (statistics.runs() < 2) continue;
      const NoiseBias& noise_bias = group.stages[stage].noise_bias.emplace(
          noise_and_bias(statistics, whole.radiance,
                         whole.variance.empty() ? nullptr : &whole.variance, confidence));
      group.stages[stage].spectrum =
          noise_spectrum(statistics, noise_bias.mean_luminance, confidence);
    }
    measurer.add_means(group);
    for (const Group& earlier : groups) {
      if (group.planned->method != earlier.planned->method &&
          comparable(group.planned->parameters, earlier.planned->parameters)) {
        measurer.add_comparisons(group, earlier);
      }
    }
    keep_compared(group);
    groups.push_back(std::move(group));
    sink(measurer.take());
  }
}

}  // namespace occlab
