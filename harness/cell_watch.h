#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace occlab {

/// Ends the process where one cell takes too long: a shader that hangs blocks the thread that waits
/// for it, and no exception gets it out of there. What was finished before is kept.
class CellWatch {
 public:
  /// Without a limit nothing is watched. `last_words` is told what was not finished just before the
  /// process ends with exit code 3; it must not wait for the thread that is watched.
  CellWatch(std::optional<double> seconds, std::function<void(const std::string&)> last_words = {});
  ~CellWatch();
  CellWatch(const CellWatch&) = delete;
  CellWatch& operator=(const CellWatch&) = delete;

  /// Runs `work` under the limit; `what` names it in the message. One at a time.
  template <typename Work>
  void during(const std::string& what, const Work& work) {
    start(what);
    struct Stop {
      CellWatch& watch;
      ~Stop() { watch.stop(); }
    } const at_the_end{*this};
    work();
  }

 private:
  void start(const std::string& what);
  void stop();
  void watch(const std::stop_token& ended);

  std::optional<double> seconds_;
  std::function<void(const std::string&)> last_words_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::string what_;
  std::optional<std::chrono::steady_clock::time_point> deadline_;
  std::jthread thread_;  ///< last: it uses all of the above
};

}  // namespace occlab
