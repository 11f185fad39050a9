#include "harness/certification.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "harness/cells.h"
#include "harness/measurement_facts.h"
#include "harness/metrics/prepared_pair.h"
#include "harness/statistics.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr double normal_95 = 1.959964;

const MetricInfo& rmse_metric() { return *std::ranges::find(metrics(), "rmse", &MetricInfo::name); }

Measurement reference_row(const MeasuredCell& reference, const Measurement& identity,
                          const char* name) {
  Measurement row = identity;
  row.method = reference.planned.method;
  row.parameters = named_parameters(reference.planned.parameters);
  // Not "all": no table of methods shows these rows.
  const ParameterSet& parameters = reference.planned.parameters;
  row.seed = std::to_string(parameters.has("seed") ? parameters.integer("seed") : 0);
  row.metric = name;
  row.unit = "1";
  row.cells = {reference.id};
  row.reference_cell = reference.id;
  row.n = 1;
  return row;
}

/// Mean over foreground and channels of the variance, in squared mean luminances.
double mean_variance(const Layers& layers, std::size_t& pixels) {
  const Image& radiance = layers.at("radiance");
  const Image& variance = layers.at("radiance_variance");
  // Compared with itself: refuses what is not finite, and divides by the mean luminance.
  const PreparedPair pair = prepare({.reference = radiance,
                                     .test = radiance,
                                     .mask = layers.at("mask"),
                                     .reference_variance = &variance});
  if (!pair.failure.empty()) throw InputError("the reference: " + pair.failure);
  double sum = 0.0;
  for (const Plane& plane : *pair.reference_variance) {
    for (const float value : plane) sum += double(value);
  }
  pixels = pair.foreground_count;
  return sum / (3.0 * double(pixels));
}

/// Rows of `rmse` over the whole frame and all seeds, against that reference.
std::vector<const Measurement*> errors_to_judge(const std::vector<Measurement>& measurements,
                                                const std::string& reference_cell) {
  std::vector<const Measurement*> rows;
  for (const Measurement& row : measurements) {
    const bool other = !row.reference_cell.empty() && row.reference_cell != reference_cell;
    if (row.metric == "rmse" && row.seed == "all" && !is_region(row) && !other) {
      rows.push_back(&row);
    }
  }
  return rows;
}

/// "s3ho, samples 32, filtered": the parameters in which the rows differ.
std::string describe(const Measurement& row, const std::vector<const Measurement*>& rows) {
  std::string text = row.method;
  for (const auto& parameter : row.parameters) {
    const bool differs = std::ranges::any_of(rows, [&](const Measurement* other) {
      const std::string* value = find_parameter(*other, parameter.first);
      return value && *value != parameter.second;
    });
    if (differs) text += fmt::format(", {} {}", parameter.first, parameter.second);
  }
  return row.stage.empty() ? text : text + ", " + row.stage;
}

/// Whether more rays would tell the error: it is not the test image that is not finite.
bool within_noise(const Measurement& row) {
  return row.reason.find("the reference's own noise") != std::string::npos;
}

const Measurement* find_metric(const std::vector<Measurement>& rows, const std::string& metric) {
  const auto found = std::ranges::find(rows, metric, &Measurement::metric);
  return found == rows.end() ? nullptr : &*found;
}

}  // namespace

std::optional<double> Certification::share() const {
  if (!reason.empty() || !half_width || !smallest_error) return std::nullopt;
  return *half_width / *smallest_error;
}

std::string Certification::verdict() const {
  const std::string rays =
      rays_per_pixel > 0 ? fmt::format("; {} rays a pixel", rays_per_pixel) : "";
  if (!share()) return fmt::format("NOT certified: {}{}", reason, rays);
  const std::string what = fmt::format(
      "the reference's 95% half-width is {:.3g}% of the smallest error ({}, rmse "
      "{:.3g}){}",
      100.0 * *share(), smallest, *smallest_error, rays);
  if (certified()) return "certified: " + what;
  return fmt::format("NOT certified: {}, more than {:g}%; the budget of {} rays a pixel ended",
                     what, 100.0 * tolerance, max_rays_per_pixel);
}

std::vector<Measurement> reference_rows(const MeasuredCell& reference, const Layers& layers,
                                        const ReferenceSettings& settings,
                                        const Measurement& identity) {
  std::vector<Measurement> rows;
  Measurement interval = reference_row(reference, identity, "reference_interval");
  interval.unit = "mean luminance";
  if (layers.find("radiance_variance")) {
    std::size_t pixels = 0;
    interval.value = normal_95 * std::sqrt(mean_variance(layers, pixels));
    interval.n = long(pixels);
  } else {
    interval.n = 0;
    interval.reason = fmt::format("method '{}' states no variance", reference.planned.method);
  }
  rows.push_back(std::move(interval));
  const auto add = [&](const char* name, double value) {
    Measurement row = reference_row(reference, identity, name);
    row.value = value;
    rows.push_back(std::move(row));
  };
  add("reference_tolerance", settings.tolerance);
  const ParameterSet& parameters = reference.planned.parameters;
  if (parameters.has("rays_per_pixel")) {
    const long rays = parameters.integer("rays_per_pixel");
    add("reference_rays_per_pixel", double(rays));
    add("reference_max_rays_per_pixel", double(settings.max_rays_per_pixel.value_or(rays)));
  }
  return rows;
}

std::optional<Certification> certify(const std::vector<Measurement>& measurements) {
  const Measurement* interval = find_metric(measurements, "reference_interval");
  if (!interval) return std::nullopt;
  Certification result;
  result.method = interval->method;
  result.half_width = interval->value;
  result.reason = interval->reason;
  const auto value_of = [&](const char* name) {
    const Measurement* row = find_metric(measurements, name);
    return row && row->value ? *row->value : 0.0;
  };
  result.tolerance = value_of("reference_tolerance");
  result.rays_per_pixel = long(value_of("reference_rays_per_pixel"));
  result.max_rays_per_pixel = long(value_of("reference_max_rays_per_pixel"));
  const std::vector<const Measurement*> errors =
      errors_to_judge(measurements, interval->reference_cell);
  for (const Measurement* row : errors) {
    if (!row->value) {
      if (result.reason.empty() && within_noise(*row)) {
        result.reason = describe(*row, errors) + ": " + row->reason;
      }
    } else if (!result.smallest_error || *row->value < *result.smallest_error) {
      result.smallest_error = row->value;
      result.smallest = describe(*row, errors);
    }
  }
  if (result.reason.empty() && !(result.smallest_error.value_or(0.0) > 0.0)) {
    result.reason = "there is no error to judge";
  }
  return result;
}

std::vector<Measurement> quick_errors(const std::vector<MeasuredCell>& cells,
                                      const Layers& reference, const Measurement& identity,
                                      const ReadLayers& read) {
  std::vector<Measurement> rows;
  std::set<int> seen;
  std::vector<PlannedCell> planned;
  for (const MeasuredCell& cell : cells) planned.push_back(cell.planned);
  for (const MeasuredCell& cell : cells) {
    if (cell.planned.role == Role::reference || !seen.insert(cell.planned.group).second) continue;
    if (reference_place(planned, cell.planned) != 0) continue;
    const Layers layers = read(cell);
    for (const StageImage& stage : stage_images(layers)) {
      const Image* variance = reference.find("radiance_variance");
      const PreparedPair pair = prepare({.reference = reference.at("radiance"),
                                         .test = stage.image,
                                         .mask = reference.at("mask"),
                                         .reference_variance = variance});
      const Measured rmse = pair.failure.empty() ? rmse_metric().measure(pair)
                                                 : Measured{std::nullopt, pair.failure, 0};
      Measurement row = identity;
      row.method = cell.planned.method;
      row.parameters = named_parameters(cell.planned.parameters);
      row.seed = "all";
      row.stage = stage.name;
      row.metric = "rmse";
      row.value = rmse.value;
      row.reason = rmse.reason;
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

nlohmann::json to_json(const Certification& certification) {
  const auto number = [](const std::optional<double>& value) {
    return value ? nlohmann::json(*value) : nlohmann::json();
  };
  return {{"certified", certification.certified()},
          {"verdict", certification.verdict()},
          {"rays_per_pixel", certification.rays_per_pixel},
          {"max_rays_per_pixel", certification.max_rays_per_pixel},
          {"half_width", number(certification.half_width)},
          {"smallest_error", number(certification.smallest_error)},
          {"smallest_error_of", certification.smallest},
          {"share", number(certification.share())},
          {"tolerance", certification.tolerance}};
}

long more_rays(const Certification& certification, long step) {
  if (!certification.open()) return 0;
  const auto rays = double(certification.rays_per_pixel);
  double wanted = rays;
  if (const auto share = certification.share()) {
    // 5% more, for the share is only known roughly and has to be below the tolerance.
    wanted = rays * (1.05 * std::pow(*share / certification.tolerance, 2.0) - 1.0);
    // Few stratified rays tell too much: the error falls faster than with the root of their number.
    wanted = std::min(wanted, 3.0 * rays);
  }
  const auto left = double(certification.max_rays_per_pixel - certification.rays_per_pixel);
  const double steps = std::ceil(std::max(wanted, 1.0) / double(step));
  return long(std::min(steps * double(step), left));
}

namespace {

/// The rows of each scene, view, resolution, probe and reference, in order of appearance.
std::vector<std::vector<Measurement>> by_bench(const std::vector<Measurement>& measurements) {
  std::vector<std::vector<Measurement>> benches;
  for (const Measurement& row : measurements) {
    // Of a region's view "main [corner]" nothing is judged.
    if (is_region(row) || !(is_of_reference(row) || (row.metric == "rmse" && row.seed == "all"))) {
      continue;
    }
    const auto known = std::ranges::find_if(benches, [&](const std::vector<Measurement>& bench) {
      const Measurement& first = bench.front();
      return first.scene == row.scene && first.view == row.view &&
             first.resolution == row.resolution && first.probe == row.probe &&
             (first.reference_cell.empty() || row.reference_cell.empty() ||
              first.reference_cell == row.reference_cell);
    });
    if (known == benches.end()) {
      benches.push_back({row});
    } else {
      known->push_back(row);
    }
  }
  return benches;
}

/// What tells the benches apart.
std::vector<std::pair<const char*, std::string Measurement::*>> bench_columns(
    const std::vector<std::vector<Measurement>>& benches) {
  std::vector<std::pair<const char*, std::string Measurement::*>> columns = {
      {"scene", &Measurement::scene},
      {"view", &Measurement::view},
      {"resolution", &Measurement::resolution},
      {"probe", &Measurement::probe}};
  std::erase_if(columns, [&](const auto& column) {
    return std::ranges::all_of(benches, [&](const std::vector<Measurement>& bench) {
      return bench.front().*column.second == benches.front().front().*column.second;
    });
  });
  return columns;
}

}  // namespace

Table reference_table(const std::vector<Measurement>& measurements) {
  Table table{
      .name = "reference", .title = "The reference", .columns = {}, .rows = {}, .notes = {}};
  const std::vector<std::vector<Measurement>> benches = by_bench(measurements);
  const auto names = bench_columns(benches);
  for (const std::vector<Measurement>& bench : benches) {
    const std::optional<Certification> found = certify(bench);
    if (!found) continue;
    const auto number = [&](const std::optional<double>& value) -> TableCell {
      if (value) return TableNumber{*value, {}, {}};
      return TableMissing{found->reason};
    };
    std::vector<TableColumn> columns;
    std::vector<TableCell> row;
    const auto add = [&](std::string name, std::string unit, TableCell cell) {
      const bool text = std::holds_alternative<std::string>(cell);
      columns.push_back(
          {std::move(name), std::move(unit), text ? Alignment::left : Alignment::right});
      row.push_back(std::move(cell));
    };
    for (const auto& [name, member] : names) add(name, "", bench.front().*member);
    add("method", "", found->method);
    if (found->rays_per_pixel > 0) {
      add("rays", "a pixel", TableNumber{double(found->rays_per_pixel), {}, {}});
      add("budget", "rays a pixel", TableNumber{double(found->max_rays_per_pixel), {}, {}});
    }
    add("95% half-width", "mean luminance", number(found->half_width));
    add("smallest error", "mean luminance", number(found->smallest_error));
    add("of", "", found->smallest.empty() ? std::string("none") : found->smallest);
    add("share", "", number(found->share()));
    add("certified", "", std::string(found->certified() ? "yes" : "no"));
    table.columns = std::move(columns);
    table.rows.push_back(std::move(row));
    if (benches.size() == 1) table.notes.push_back(found->verdict());
    if (table.rows.size() == 1) {
      table.notes.push_back(
          fmt::format("95% half-width: 1.96 root mean variance of the reference's pixels; "
                      "smallest error: the smallest rmse of all methods and stages over the "
                      "whole frame; certified where their ratio is at most {:g}",
                      found->tolerance));
    }
  }
  return table;
}

}  // namespace occlab
