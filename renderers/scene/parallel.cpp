#include "renderers/scene/parallel.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <string_view>
#include <thread>
#include <vector>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr int max_threads = 1024;
std::atomic<int> requested_threads{0};

int default_thread_count() {
  const char* text = std::getenv("OCCLAB_THREADS");
  if (text == nullptr) return std::max(1, int(std::thread::hardware_concurrency()));
  const std::string_view view(text);
  int count = 0;
  const auto [end, error] = std::from_chars(view.data(), view.data() + view.size(), count);
  if (error != std::errc{} || end != view.data() + view.size() || count < 1 ||
      count > max_threads) {
    throw InputError(fmt::format(
        "environment variable OCCLAB_THREADS: found '{}'; accepted: an integer from 1 to {}", view,
        max_threads));
  }
  return count;
}

}  // namespace

int thread_count() {
  const int requested = requested_threads.load();
  return requested > 0 ? requested : default_thread_count();
}

void set_thread_count(int count) { requested_threads.store(std::clamp(count, 0, max_threads)); }

namespace detail {

void run_workers(std::size_t count, const std::function<void()>& worker) {
  const std::size_t threads = std::min(std::size_t(thread_count()), count);
  if (threads <= 1) {
    if (count > 0) worker();
    return;
  }
  std::exception_ptr first_error;
  std::mutex mutex;
  const auto guarded = [&] {
    try {
      worker();
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!first_error) first_error = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> helpers;
    helpers.reserve(threads - 1);
    for (std::size_t i = 1; i < threads; ++i) helpers.emplace_back(guarded);
    guarded();
  }  // joins
  if (first_error) std::rethrow_exception(first_error);
}

}  // namespace detail
}  // namespace occlab
