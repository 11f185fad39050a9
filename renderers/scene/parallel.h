#pragma once

#include <atomic>
#include <cstddef>
#include <functional>

namespace occlab {

/// Threads that parallel_for uses, the caller's included: set_thread_count(), else the environment
/// variable OCCLAB_THREADS, else the hardware's. At least 1. A malformed OCCLAB_THREADS throws
/// InputError.
int thread_count();

/// Overrides the number of threads for the whole process; 0 goes back to OCCLAB_THREADS or the
/// hardware.
void set_thread_count(int count);

namespace detail {
/// Runs `worker` on thread_count() threads (at most `count`) and joins them.
void run_workers(std::size_t count, const std::function<void()>& worker);
}  // namespace detail

/// Calls body(index) for every index in [0, count), each exactly once, on thread_count() threads.
/// Indices are handed out one by one in rising order, so uneven work balances; make an index a
/// chunk of work (a row, a tile), not a single value. Returns when all calls have finished. The
/// first exception stops further indices and is rethrown here. What is computed must not depend on
/// which thread takes which index: results are then the same for every thread count.
template <typename Body>
void parallel_for(std::size_t count, const Body& body) {
  std::atomic<std::size_t> next{0};
  detail::run_workers(count, [&] {
    for (std::size_t index = next.fetch_add(1); index < count; index = next.fetch_add(1)) {
      try {
        body(index);
      } catch (...) {
        next.store(count);
        throw;
      }
    }
  });
}

}  // namespace occlab
