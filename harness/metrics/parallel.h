#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <numeric>
#include <thread>
#include <vector>

namespace occlab {

/// Calls work(row) for every row in [0, rows), on all cores, in any order. `work` must not throw.
/// Where all rows together hold few values (`values_per_row` each) starting threads costs more than
/// it saves.
template <typename Work>
void for_each_row(int rows, Work&& work, std::size_t values_per_row = 1000) {
  constexpr std::size_t worth_a_thread = 20000;
  std::atomic<int> next = 0;
  const auto worker = [&] {
    for (int row = next++; row < rows; row = next++) work(row);
  };
  const bool small = static_cast<std::size_t>(rows) * values_per_row < worth_a_thread;
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  const int threads = small ? 1 : std::min(cores, rows);
  std::vector<std::jthread> others;
  for (int i = 1; i < threads; ++i) others.emplace_back(worker);
  worker();
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
