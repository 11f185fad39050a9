// plan_timing of config.h.

#include <algorithm>
#include <functional>

#include "harness/plan_parts.h"
#include "renderers/scene/parallel.h"

namespace occlab {
namespace {

struct Point {
  NamedValues parameters;  ///< a later value of a parameter takes an earlier one's place
  Resolution resolution;
  long triangles = 0;
  int threads = 0;
};

/// An axis is what each of its values does to a point.
struct PointAxis {
  std::string name;
  std::vector<std::function<void(Point&)>> values;
};

std::vector<PointAxis> point_axes(const TimingSettings& timing) {
  std::vector<PointAxis> axes;
  const auto add = [&](const char* name, const auto& values, auto set) {
    PointAxis axis{name, {}};
    for (const auto& value : values) {
      axis.values.emplace_back([value, set](Point& point) { set(point, value); });
    }
    if (!axis.values.empty()) axes.push_back(std::move(axis));
  };
  add(threads_axis, timing.threads, [](Point& point, long value) { point.threads = int(value); });
  add(triangles_axis, timing.triangles, [](Point& point, long value) { point.triangles = value; });
  add(resolution_axis, timing.resolutions,
      [](Point& point, Resolution value) { point.resolution = value; });
  for (const Axis& axis : timing.axes) {
    add(axis.parameter.c_str(), axis.values,
        [name = axis.parameter](Point& point, const ParameterValue& value) {
          point.parameters.emplace_back(name, value);
        });
  }
  return axes;
}

std::vector<TimedCell> cells_of(const Experiment& experiment, const Point& point,
                                const std::vector<MethodInfo>& methods) {
  std::vector<TimedCell> cells;
  for (const std::string& name : experiment.timing->methods) {
    const MethodInfo& method = planned_method(methods, name);
    ParameterSet parameters = common_parameters(experiment, method);
    for (const auto& [parameter, value] : point.parameters) parameters.set(parameter, value);
    cells.push_back({{Role::test, name, std::move(parameters), 0},
                     point.resolution,
                     point.triangles,
                     point.threads,
                     {}});
  }
  return cells;
}

bool same(const TimedCell& a, const TimedCell& b) {
  return a.cell.method == b.cell.method &&
         a.cell.parameters.to_string() == b.cell.parameters.to_string() &&
         a.resolution == b.resolution && a.triangles == b.triangles && a.threads == b.threads;
}

void append(std::vector<TimedCell>& all, std::vector<TimedCell> cells) {
  const int group = all.empty() ? 0 : all.back().cell.group + 1;
  for (TimedCell& cell : cells) {
    cell.cell.group = group;
    all.push_back(std::move(cell));
  }
}

/// The point's cells are on one more axis; new ones are added.
void append_on_axis(std::vector<TimedCell>& all, std::vector<TimedCell> cells,
                    const std::string& axis) {
  std::vector<TimedCell> added;
  for (TimedCell& cell : cells) {
    const auto known =
        std::ranges::find_if(all, [&](const TimedCell& other) { return same(other, cell); });
    if (known != all.end()) {
      known->axes.push_back(axis);
    } else {
      cell.axes = {axis};
      added.push_back(std::move(cell));
    }
  }
  append(all, std::move(added));
}

std::vector<Point> crossed(const Point& base, const std::vector<PointAxis>& axes) {
  std::vector<Point> points = {base};
  for (const PointAxis& axis : axes) {
    std::vector<Point> more;
    for (const Point& point : points) {
      for (const auto& set : axis.values) {
        more.push_back(point);
        set(more.back());
      }
    }
    points = std::move(more);
  }
  return points;
}

}  // namespace

std::vector<TimedCell> plan_timing(const Experiment& experiment,
                                   const std::vector<MethodInfo>& methods) {
  std::vector<TimedCell> cells;
  if (!experiment.timing) return cells;
  const TimingSettings& timing = *experiment.timing;
  const Point base{{},
                   {experiment.scene.width, experiment.scene.height},
                   0,
                   timing.threads.empty() ? 0 : std::min(thread_count(), most_rasteriser_threads)};
  const std::vector<PointAxis> axes = point_axes(timing);
  if (!timing.one_by_one) {
    for (const Point& point : crossed(base, axes)) {
      append(cells, cells_of(experiment, point, methods));
    }
    return cells;
  }
  for (const PointAxis& axis : axes) {
    for (const auto& set : axis.values) {
      Point point = base;
      set(point);
      append_on_axis(cells, cells_of(experiment, point, methods), axis.name);
    }
  }
  return cells;
}

}  // namespace occlab
