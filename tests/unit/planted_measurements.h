#pragma once

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "harness/measurements.h"

namespace occlab {

// Measurements of invented methods whose differences are known.

inline constexpr double infinity = std::numeric_limits<double>::infinity();
using Values = std::vector<double>;

/// Eight seeds around a value, the same deviations in different orders.
inline Values around(double centre, double spread, std::size_t turn = 0) {
  const Values deviations = {-0.9, 0.4, 1.1, -0.3, 0.6, -1.2, 0.1, 0.2};
  Values values;
  for (std::size_t i = 0; i < 8; ++i) {
    values.push_back(centre + spread * deviations[(i * 3 + turn) % 8]);
  }
  return values;
}

inline Measurement base(const std::string& method, const std::string& metric) {
  Measurement m;
  m.experiment = "s3ho";
  m.scene = "gallery";
  m.view = "main";
  m.method = method;
  m.parameters = {{"samples", "32"}};
  m.stage = "filtered";
  m.metric = metric;
  return m;
}

/// The rows of each seed and the one over all seeds. A NaN stands for a seed without a value.
inline void add(std::vector<Measurement>& rows, Measurement m, const Values& values) {
  double sum = 0.0;
  for (std::size_t seed = 0; seed < values.size(); ++seed) {
    m.seed = fmt::format("{}", seed);
    m.value = values[seed];
    m.reason = "";
    if (std::isnan(values[seed])) {
      m.value.reset();
      m.reason = "3 pixels are NaN";
    }
    rows.push_back(m);
    sum += values[seed];
  }
  m.seed = "all";
  m.n = long(values.size());
  m.value = sum / double(values.size());
  m.reason = "";
  if (std::isnan(sum)) {
    m.value.reset();
    m.reason = "3 pixels are NaN";
  }
  rows.push_back(m);
}

inline std::vector<Measurement> measure(const std::map<std::string, Values>& methods,
                                        const std::string& metric = "rmse") {
  std::vector<Measurement> rows;
  for (const auto& [method, values] : methods) add(rows, base(method, metric), values);
  return rows;
}

}  // namespace occlab
