#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

#include "renderers/scene/parallel.h"

namespace occlab {

/// Calls work(row) for every row in [0, rows), on thread_count() threads, in any order. Where all
/// rows together hold few values (`values_per_row` each) starting threads costs more than it saves.
template <typename Work>
void for_each_row(int rows, Work&& work, std::size_t values_per_row = 1000) {
  constexpr std::size_t worth_a_thread = 20000;
  if (std::size_t(rows) * values_per_row < worth_a_thread) {
    for (int row = 0; row < rows; ++row) work(row);
  } else {
    parallel_for(std::size_t(rows), [&](std::size_t row) { work(int(row)); });
  }
}

/// The sum of value(row) over the rows; added in the order of the rows, so that it does not depend
/// on the threads.
template <typename Value>
auto sum_over_rows(int rows, Value&& value) {
  std::vector<decltype(value(0))> parts(static_cast<std::size_t>(rows));
  for_each_row(rows, [&](int row) { parts[static_cast<std::size_t>(row)] = value(row); });
  return std::accumulate(parts.begin(), parts.end(), decltype(value(0)){});
}

}  // namespace occlab
