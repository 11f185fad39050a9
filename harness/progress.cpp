#include "harness/progress.h"

#include <fmt/format.h>
#include <unistd.h>

namespace occlab {
namespace {

using Seconds = std::chrono::duration<double>;
constexpr Seconds between_lines(2.0);

}  // namespace

Progress::Progress(std::string what, std::size_t total)
    : what_(std::move(what)),
      total_(total),
      terminal_(isatty(STDERR_FILENO) == 1),
      start_(std::chrono::steady_clock::now()),
      last_line_(start_ - std::chrono::hours(1)) {}

Progress::~Progress() {
  if (line_open_) fmt::print(stderr, "\n");
}

void Progress::update(std::size_t done, const std::string& next) {
  const auto now = std::chrono::steady_clock::now();
  if (!terminal_ && Seconds(now - last_line_) < between_lines) return;
  last_line_ = now;
  std::string eta;
  if (done > 0) {
    const double left = Seconds(now - start_).count() * double(total_ - done) / double(done);
    eta = fmt::format(", {:.0f} s left", left);
  }
  const std::string line = fmt::format("{} {}/{} {}{}", what_, done + 1, total_, next, eta);
  if (terminal_) {
    fmt::print(stderr, "\r\033[K{}", line);
  } else {
    fmt::print(stderr, "{}\n", line);
  }
  line_open_ = terminal_;
}

}  // namespace occlab
