#include "harness/cell_watch.h"

#include <fmt/format.h>
#include <unistd.h>

#include <utility>

#include "renderers/scene/error.h"

namespace occlab {

CellWatch::CellWatch(std::optional<double> seconds,
                     std::function<void(const std::string&)> last_words)
    : seconds_(seconds), last_words_(std::move(last_words)) {
  if (seconds_) thread_ = std::jthread([this](const std::stop_token& ended) { watch(ended); });
}

CellWatch::~CellWatch() = default;

void CellWatch::start(const std::string& what) {
  if (!seconds_) return;
  const std::lock_guard lock(mutex_);
  what_ = what;
  deadline_ = std::chrono::steady_clock::now() +
              std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                  std::chrono::duration<double>(*seconds_));
  changed_.notify_all();
}

void CellWatch::stop() {
  const std::lock_guard lock(mutex_);
  deadline_.reset();
  changed_.notify_all();
}

void CellWatch::watch(const std::stop_token& ended) {
  std::unique_lock lock(mutex_);
  while (!ended.stop_requested()) {
    if (!deadline_) {
      changed_.wait(lock, ended, [&] { return deadline_.has_value(); });
      continue;
    }
    const auto deadline = *deadline_;
    changed_.wait_until(lock, ended, deadline, [&] { return deadline_ != deadline; });
    if (ended.stop_requested() || deadline_ != deadline) continue;
    const std::string message = fmt::format(
        "{}: not finished within {:g} s (--cell-time-limit); finished cells are kept, the same "
        "command goes on from there",
        what_, *seconds_);
    if (last_words_) last_words_(message);
    fmt::print(stderr, "occlab: {}\n", message);
    ::_exit(exit_device_failed);
  }
}

}  // namespace occlab
