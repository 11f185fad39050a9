#pragma once

#include <string>
#include <utility>
#include <vector>

#include "renderers/methods/parameters.h"

namespace occlab {

/// Values by name, in file order.
using NamedValues = std::vector<std::pair<std::string, ParameterValue>>;

/// What is varied, and the values it takes.
struct Axis {
  std::string parameter;
  std::vector<ParameterValue> values;  ///< not empty; all different unless it is part of a zip
};

/// Axes that are crossed, the first varying slowest, except that those of a zip go together.
struct Grid {
  std::vector<Axis> axes;
  /// Names of axes with equally many values, which take their first values together, then their
  /// second ones and so on; in the crossing they have the place of the first of them.
  std::vector<std::vector<std::string>> zips;
  /// A point is left out that has, for each axis of an exclusion, one of its values.
  std::vector<std::vector<Axis>> exclusions;
};

/// How many points cross() makes; a number too large for long is the largest one.
long count_crossed(const Grid& grid);

/// Every point of the crossed axes, exclusions included. Without axes, one empty point.
std::vector<NamedValues> cross(const Grid& grid);

/// Whether the point has, for each axis, one of its values. Numbers are equal as numbers are.
bool has_values(const NamedValues& point, const std::vector<Axis>& exclusion);
bool is_excluded(const NamedValues& point, const Grid& grid);

/// The points that no exclusion leaves out.
std::vector<NamedValues> points(const Grid& grid);

}  // namespace occlab
