#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "harness/cells.h"
#include "harness/error_budget.h"
#include "renderers/methods/failure_classes.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr std::array<const char*, 5> part_names = {"representation", "visibility", "sampling",
                                                   "filter", "total"};
constexpr std::size_t total = 4;

/// Sums over the surface's pixels and the three channels.
struct PartSums {
  double sum = 0.0;
  double squares = 0.0;
  double with_total = 0.0;
};
using BudgetSums = std::array<PartSums, part_names.size()>;

/// The reference and what all groups share.
class BudgetMeasurer {
 public:
  BudgetMeasurer(const StoredBudget& budget, const Layers& reference, std::string reference_id,
                 const Measurement& identity)
      : budget_(budget),
        radiance_(reference.at("radiance")),
        mask_(reference.at("mask")),
        variance_(reference.find("radiance_variance")),
        reference_id_(std::move(reference_id)),
        identity_(identity) {
    double luminance = 0.0;
    for (std::size_t p = 0; p < mask_.pixel_count(); ++p) {
      if (mask_.values()[p] <= 0.5f) continue;
      const auto rgb = radiance_.values().subspan(3 * p, 3);
      luminance += 0.2126 * double(rgb[0]) + 0.7152 * double(rgb[1]) + 0.0722 * double(rgb[2]);
      if (variance_) {
        for (const float value : variance_->values().subspan(3 * p, 3)) {
          reference_squares_ += double(value);
        }
      }
      ++pixels_;
    }
    mean_luminance_ = luminance / double(pixels_);
  }

  /// One seed's image at one stage; `filtered` is null before the filter.
  BudgetSums sums(const BudgetVariant& variant, const Image& unfiltered,
                  const Image* filtered) const {
    const Image& traced = budget_.layers.at(variant.name + "_traced");
    const Image& depth = budget_.layers.at(variant.name + "_depth");
    BudgetSums sums;
    for (std::size_t i = 0; i < radiance_.values().size(); ++i) {
      if (mask_.values()[i / 3] <= 0.5f) continue;
      const double R = double(radiance_.values()[i]);
      const double T = double(traced.values()[i]);
      const double D = double(depth.values()[i]);
      const double X = double(unfiltered.values()[i]);
      const double F = filtered ? double(filtered->values()[i]) : X;
      const std::array<double, part_names.size()> parts = {T - R, D - T, X - D, F - X, F - R};
      for (std::size_t part = 0; part < parts.size(); ++part) {
        sums[part].sum += parts[part];
        sums[part].squares += parts[part] * parts[part];
        sums[part].with_total += parts[part] * parts[total];
      }
    }
    return sums;
  }

  /// Rows of a group at a stage, from the sums of its seeds.
  void add_group(const PlannedCell& planned, const std::vector<std::string>& cells,
                 const std::string& stage, const BudgetVariant& variant,
                 const std::vector<BudgetSums>& seeds) {
    Measurement row = new_row(cells);
    row.method = planned.method;
    row.parameters = named_parameters(planned.parameters);
    row.stage = stage;
    row.n = long(seeds.size());
    BudgetSums all;
    for (const BudgetSums& seed : seeds) {
      for (std::size_t part = 0; part < all.size(); ++part) {
        all[part].sum += seed[part].sum;
        all[part].squares += seed[part].squares;
        all[part].with_total += seed[part].with_total;
      }
    }
    const double count = 3.0 * double(pixels_) * double(seeds.size());
    for (std::size_t part = 0; part < all.size(); ++part) {
      const std::string name = part_names[part];
      if (stage == "unfiltered" && name == "filter") continue;
      add(row, "budget_rms." + name, "mean luminance",
          std::sqrt(all[part].squares / count) / mean_luminance_);
      add(row, "budget_mean." + name, "mean luminance", all[part].sum / count / mean_luminance_);
      add(row, "budget_share." + name, "1", all[part].with_total / all[total].squares);
    }
    const double traced = fact(variant.name + "_traced_standard_error");
    const double depth = fact(variant.name + "_depth_standard_error");
    const double reference =
        std::sqrt(reference_squares_ / (3.0 * double(pixels_))) / mean_luminance_;
    add(row, "budget_floor", "mean luminance",
        std::sqrt(traced * traced + depth * depth + reference * reference));
  }

  void add_classes() {
    Measurement row = new_row({});
    row.method = "march";
    row.parameters = march_parameters();
    std::vector<double> visibility_error(radiance_.values().size());
    for (const std::string_view name : failure_class_names) {
      const Image& radiance = budget_.layers.at(std::string(name) + "_radiance");
      for (std::size_t i = 0; i < visibility_error.size(); ++i) {
        visibility_error[i] += double(radiance.values()[i]);
      }
    }
    double squares = 0.0;
    for (std::size_t i = 0; i < visibility_error.size(); ++i) {
      if (mask_.values()[i / 3] > 0.5f) squares += visibility_error[i] * visibility_error[i];
    }
    for (const std::string_view name : failure_class_names) {
      add_class(row, std::string(name), visibility_error, squares);
    }
    add(row, "failure_floor", "1", fact("classes_standard_error"));
  }

  std::vector<Measurement> take() { return std::move(rows_); }

 private:
  void add_class(const Measurement& row, const std::string& name,
                 const std::vector<double>& visibility_error, double error_squares) {
    constexpr double noticed = 0.01;  // of k_A
    const Image& occlusion = budget_.layers.at(name + "_occlusion");
    const Image& radiance = budget_.layers.at(name + "_radiance");
    double sum = 0.0;
    double squares = 0.0;
    double shared = 0.0;
    std::size_t affected = 0;
    for (std::size_t p = 0; p < mask_.pixel_count(); ++p) {
      if (mask_.values()[p] <= 0.5f) continue;
      const double k_A = double(occlusion.values()[p]);
      sum += k_A;
      squares += k_A * k_A;
      affected += std::abs(k_A) > noticed ? 1 : 0;
      for (std::size_t i = 3 * p; i < 3 * p + 3; ++i) {
        shared += double(radiance.values()[i]) * visibility_error[i];
      }
    }
    const auto pixels = double(pixels_);
    add(row, "failure_pixels." + name, "1", double(affected) / pixels);
    add(row, "failure_mean." + name, "1", sum / pixels);
    add(row, "failure_rms." + name, "1", std::sqrt(squares / pixels));
    if (error_squares > 0.0) {
      add(row, "failure_share." + name, "1", shared / error_squares);
    } else {
      add(row, "failure_share." + name, "1", "march and rays agree everywhere");
    }
  }

  /// The parameters of the march, which all variants share.
  std::vector<std::pair<std::string, std::string>> march_parameters() const {
    const ParameterSet& parameters = budget_.cell.variants.front().planned.parameters;
    std::vector<std::pair<std::string, std::string>> named;
    for (const Parameter& parameter : parameters.declared()) {
      if (parameter.factor != Factor::visibility) continue;
      named.emplace_back(parameter.name, to_string(parameters.value(parameter.name)));
    }
    return named;
  }

  Measurement new_row(const std::vector<std::string>& cells) const {
    Measurement row = identity_;
    row.seed = "all";
    row.n = 1;
    row.reference_cell = reference_id_;
    row.cells = cells;
    row.cells.push_back(budget_.id);
    return row;
  }

  double fact(const std::string& name) const { return std::stod(budget_.facts.at(name)); }

  void add(Measurement row, const std::string& metric, const std::string& unit, double value) {
    row.metric = metric;
    row.unit = unit;
    if (std::isfinite(value)) {
      row.value = value;
    } else {
      row.reason = "the reference is black, or the method equals it";
    }
    rows_.push_back(std::move(row));
  }
  void add(Measurement row, const std::string& metric, const std::string& unit,
           const std::string& reason) {
    row.metric = metric;
    row.unit = unit;
    row.reason = reason;
    rows_.push_back(std::move(row));
  }

  const StoredBudget& budget_;
  const Image& radiance_;
  const Image& mask_;
  const Image* variance_;
  std::string reference_id_;
  Measurement identity_;
  double reference_squares_ = 0.0;
  std::size_t pixels_ = 0;  ///< foreground
  double mean_luminance_ = 0.0;
  std::vector<Measurement> rows_;
};

}  // namespace

std::vector<Measurement> measure_budget(const StoredBudget& budget,
                                        const std::vector<MeasuredCell>& cells,
                                        const Measurement& identity, const ReadLayers& read) {
  const Layers reference = read(cells.front());
  BudgetMeasurer measurer(budget, reference, cells.front().id, identity);
  struct Group {
    const PlannedCell* planned = nullptr;
    const BudgetVariant* variant = nullptr;
    std::vector<std::string> cells;
    std::map<std::string, std::vector<BudgetSums>> stages;
  };
  std::map<int, Group> groups;
  for (const MeasuredCell& cell : cells) {
    const BudgetVariant* variant = find_variant(budget.cell, cell.planned);
    if (!variant) continue;
    Group& group = groups[cell.planned.group];
    if (!group.planned) group.planned = &cell.planned;
    group.variant = variant;
    group.cells.push_back(cell.id);
    const Layers layers = read(cell);
    const Image* unfiltered = layers.find("radiance_unfiltered");
    const Image& radiance = layers.at("radiance");
    group.stages["unfiltered"].push_back(
        measurer.sums(*variant, unfiltered ? *unfiltered : radiance, nullptr));
    if (unfiltered) {
      group.stages["filtered"].push_back(measurer.sums(*variant, *unfiltered, &radiance));
    }
  }
  for (const auto& [id, group] : groups) {
    for (const auto& [stage, seeds] : group.stages) {
      measurer.add_group(*group.planned, group.cells, stage, *group.variant, seeds);
    }
  }
  measurer.add_classes();
  return measurer.take();
}

}  // namespace occlab
