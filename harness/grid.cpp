#include "harness/grid.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace occlab {
namespace {

/// Axes that vary together: one, or those of a zip.
using Joint = std::vector<const Axis*>;

const std::vector<std::string>* zip_of(const Grid& grid, const std::string& name) {
  for (const std::vector<std::string>& zip : grid.zips) {
    if (std::ranges::find(zip, name) != zip.end()) return &zip;
  }
  return nullptr;
}

std::vector<Joint> joint_axes(const Grid& grid) {
  std::vector<Joint> joints;
  for (const Axis& axis : grid.axes) {
    const std::vector<std::string>* const zip = zip_of(grid, axis.parameter);
    const auto partner = std::ranges::find_if(joints, [&](const Joint& joint) {
      return zip && zip_of(grid, joint.front()->parameter) == zip;
    });
    if (partner == joints.end()) {
      joints.push_back({&axis});
    } else {
      assert(partner->front()->values.size() == axis.values.size());
      partner->push_back(&axis);
    }
  }
  return joints;
}

bool same_value(const ParameterValue& a, const ParameterValue& b) {
  const auto number = [](const ParameterValue& value, double& result) {
    if (const auto* integer = std::get_if<long>(&value)) {
      result = double(*integer);
    } else if (const auto* real = std::get_if<double>(&value)) {
      result = *real;
    } else {
      return false;
    }
    return true;
  };
  double number_a = 0.0;
  double number_b = 0.0;
  if (number(a, number_a) && number(b, number_b)) return number_a == number_b;
  return a == b;
}

}  // namespace

long count_crossed(const Grid& grid) {
  long count = 1;
  for (const Joint& joint : joint_axes(grid)) {
    const long values = std::ssize(joint.front()->values);
    if (__builtin_mul_overflow(count, values, &count)) return std::numeric_limits<long>::max();
  }
  return count;
}

std::vector<NamedValues> cross(const Grid& grid) {
  std::vector<NamedValues> points = {{}};
  for (const Joint& joint : joint_axes(grid)) {
    std::vector<NamedValues> longer;
    longer.reserve(points.size() * joint.front()->values.size());
    for (const NamedValues& point : points) {
      for (std::size_t i = 0; i < joint.front()->values.size(); ++i) {
        longer.push_back(point);
        for (const Axis* axis : joint) {
          longer.back().emplace_back(axis->parameter, axis->values[i]);
        }
      }
    }
    points = std::move(longer);
  }
  return points;
}

bool has_values(const NamedValues& point, const std::vector<Axis>& exclusion) {
  return std::ranges::all_of(exclusion, [&](const Axis& axis) {
    return std::ranges::any_of(point, [&](const auto& named) {
      return named.first == axis.parameter &&
             std::ranges::any_of(axis.values, [&](const ParameterValue& value) {
               return same_value(value, named.second);
             });
    });
  });
}

bool is_excluded(const NamedValues& point, const Grid& grid) {
  return std::ranges::any_of(grid.exclusions,
                             [&](const auto& exclusion) { return has_values(point, exclusion); });
}

std::vector<NamedValues> points(const Grid& grid) {
  std::vector<NamedValues> all = cross(grid);
  std::erase_if(all, [&](const NamedValues& point) { return is_excluded(point, grid); });
  return all;
}

}  // namespace occlab
