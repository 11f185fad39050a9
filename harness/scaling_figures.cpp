#include "harness/scaling_figures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <map>

#include "harness/config.h"
#include "harness/figures/log_plot.h"
#include "harness/files.h"
#include "harness/measurement_facts.h"
#include "harness/table_rows.h"
#include "renderers/scene/image_io.h"

namespace occlab {
namespace {

using Counted = std::map<std::string, int>;

/// The commonest value of every fact but the method.
std::map<std::string, std::string> common_facts(const std::vector<RowGroup>& groups) {
  std::map<std::string, Counted> counts;
  for (const RowGroup& group : groups) {
    for (const auto& [name, value] : group.facts) ++counts[name][value];
  }
  std::map<std::string, std::string> common;
  for (const auto& [name, counted] : counts) {
    if (name != "method") {
      common[name] = std::ranges::max_element(counted, {}, &Counted::value_type::second)->first;
    }
  }
  return common;
}

bool is_on(const RowGroup& group, const std::string& axis,
           const std::map<std::string, std::string>& common) {
  return std::ranges::all_of(group.facts, [&](const auto& named) {
    const auto& [name, value] = named;
    return name == "method" || name == axis || value == common.at(name);
  });
}

/// Where a value is on its axis: a number, of a resolution its pixels.
double place_of(const std::string& value) {
  double first = 0.0;
  const char* const end = value.data() + value.size();
  const auto read = std::from_chars(value.data(), end, first);
  double second = 1.0;
  if (read.ptr != end && *read.ptr == 'x') std::from_chars(read.ptr + 1, end, second);
  return first * second;
}

std::string axis_label(const std::string& axis) {
  if (axis == resolution_axis) return "resolution, pixels";
  if (axis == "samples") return "samples N, directions a pixel";
  if (axis == "steps") return "march steps S a direction";
  if (axis == "d_max_world") return "d_max, scene units";
  return axis;
}

struct VariedAxis {
  std::string name;
  std::vector<const RowGroup*> groups;
};

LogPanel panel_of(const VariedAxis& axis, const std::string& pass,
                  const std::vector<std::string>& methods) {
  LogPanel panel{fmt::format("{}, ms", pass == "frame" ? "whole frame" : pass + " pass"),
                 axis_label(axis.name),
                 {},
                 {}};
  for (std::size_t i = 0; i < methods.size(); ++i) {
    LogSeries series{methods[i], frame_colour(i), {}};
    for (const RowGroup* group : axis.groups) {
      const Measurement* const time = group->find("time_ms." + pass);
      if (fact(group->facts, "method") != methods[i] || !time || !time->value) continue;
      const std::string value = fact(group->facts, axis.name);
      series.points.push_back({place_of(value), *time->value, *time->lower, *time->upper});
      const std::pair<double, std::string> tick(series.points.back().x, value);
      if (axis.name == resolution_axis &&
          std::ranges::find(panel.x_ticks, tick) == panel.x_ticks.end()) {
        panel.x_ticks.push_back(tick);
      }
    }
    panel.series.push_back(std::move(series));
  }
  std::ranges::sort(panel.x_ticks);
  return panel;
}

/// "samples = 8, steps = 2, ..." of what is not varied, as far as some axis varies it.
std::string base_text(const std::vector<std::string>& axes, const std::string& varied,
                      const std::map<std::string, std::string>& common) {
  std::vector<std::string> parts;
  for (const std::string& axis : axes) {
    if (axis != varied) parts.push_back(fmt::format("{} = {}", axis, common.at(axis)));
  }
  return parts.empty() ? "" : fmt::format(" Else {}.", fmt::join(parts, ", "));
}

/// "ssao 1.02 [1.01, 1.03]".
std::string exponents_text(const std::vector<Measurement>& measurements, const std::string& axis,
                           const std::string& pass) {
  std::vector<std::string> parts;
  for (const Measurement& m : measurements) {
    if (m.metric != fmt::format("time_exponent.{}.{}", axis, pass) || !m.value) continue;
    std::string text = fmt::format("{} {:.2f}", m.method, *m.value);
    if (m.lower) text += fmt::format(" [{:.2f}, {:.2f}]", *m.lower, *m.upper);
    parts.push_back(text + fmt::format(" over {} points", m.n));
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

std::vector<std::string> axes_of(const std::vector<Measurement>& measurements) {
  std::vector<std::string> axes;
  for (const Measurement& m : measurements) {
    if (!is_exponent(m)) continue;
    const std::size_t first = m.metric.find('.') + 1;
    const std::string axis = m.metric.substr(first, m.metric.rfind('.') - first);
    if (std::ranges::find(axes, axis) == axes.end()) axes.push_back(axis);
  }
  return axes;
}

}  // namespace

void write_scaling_figures(const std::vector<Measurement>& measurements,
                           const std::filesystem::path& folder) {
  const std::vector<std::string> axes = axes_of(measurements);
  if (axes.empty()) return;
  const Rows rows = select_rows(measurements, is_time);
  const std::vector<RowGroup> groups = group_rows(rows);
  const std::map<std::string, std::string> common = common_facts(groups);
  std::vector<std::string> methods;
  for (const Measurement* m : rows) {
    if (std::ranges::find(methods, m->method) == methods.end()) methods.push_back(m->method);
  }
  create_folder(folder);
  for (const std::string& name : axes) {
    VariedAxis axis{name, {}};
    for (const RowGroup& group : groups) {
      if (is_on(group, name, common)) axis.groups.push_back(&group);
    }
    const bool of_triangles = name == triangles_axis;
    const bool occlusion = std::ranges::any_of(axis.groups, [](const RowGroup* group) {
      return group->find("time_ms.occlusion") != nullptr;
    });
    const std::string work = of_triangles || !occlusion ? "gbuffer" : "occlusion";
    LogPlotFigure figure{
        fmt::format("Time against {}", axis_label(name)),
        {panel_of(axis, work, methods), panel_of(axis, "frame", methods)},
        fmt::format("Both axes are logarithmic. Medians, with bars from quartile to quartile where "
                    "they are longer than the "
                    "markers.{}\nExponents, {} pass: {}.\nExponents, frame: {}.\n{}, by {}.",
                    base_text(axes, name, common), work, exponents_text(measurements, name, work),
                    exponents_text(measurements, name, "frame"), rows.front()->device,
                    rows.front()->clock)};
    write_png(folder / fmt::format("scaling_{}.png", name), log_plot_figure(figure));
  }
}

}  // namespace occlab
