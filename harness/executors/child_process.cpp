#include "harness/executors/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <sstream>

#include "harness/spawn.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

/// A pipe whose ends this program closes and no child inherits but by adddup2.
class Pipe {
 public:
  Pipe() {
    if (::pipe2(ends_.data(), O_CLOEXEC) != 0) {
      throw DeviceError(fmt::format("no pipe to a program: {}", std::strerror(errno)));
    }
  }
  ~Pipe() {
    close_end(0);
    close_end(1);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  int read_end() const { return ends_[0]; }
  int write_end() const { return ends_[1]; }
  void close_end(std::size_t end) {
    if (ends_[end] >= 0) ::close(ends_[end]);
    ends_[end] = -1;
  }

 private:
  std::array<int, 2> ends_ = {-1, -1};
};

/// Reads both until the child has closed them.
void read_both(Pipe& out, Pipe& err, ChildResult& result) {
  std::array<pollfd, 2> ends = {{{out.read_end(), POLLIN, 0}, {err.read_end(), POLLIN, 0}}};
  const std::array<std::string*, 2> texts = {&result.out, &result.err};
  std::array<char, 4096> block{};
  while (ends[0].fd >= 0 || ends[1].fd >= 0) {
    if (::poll(ends.data(), ends.size(), -1) < 0 && errno != EINTR) return;
    for (std::size_t i = 0; i < ends.size(); ++i) {
      if (ends[i].fd < 0 || ends[i].revents == 0) continue;
      const ssize_t size = ::read(ends[i].fd, block.data(), block.size());
      if (size > 0) texts[i]->append(block.data(), std::size_t(size));
      if (size == 0 || (size < 0 && errno != EINTR)) ends[i].fd = -1;
    }
  }
}

}  // namespace

ChildResult run_child(const std::vector<std::string>& command) {
  std::vector<std::string> words = command;
  Pipe out;
  Pipe err;
  SpawnActions actions;
  actions.open(STDIN_FILENO, "/dev/null", O_RDONLY);
  actions.duplicate(out.write_end(), STDOUT_FILENO);
  actions.duplicate(err.write_end(), STDERR_FILENO);
  pid_t child = 0;
  const int error = posix_spawnp(&child, words.front().c_str(), actions.get(), nullptr,
                                 spawn_words(words).data(), environ);
  if (error != 0) {
    throw DeviceError(
        fmt::format("{}: cannot be started: {}", command.front(), std::strerror(error)));
  }
  out.close_end(1);
  err.close_end(1);
  ChildResult result;
  read_both(out, err, result);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  result.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

std::string shell_word(const std::string& text) {
  std::string word = "'";
  for (const char letter : text) {
    if (letter == '\'') {
      word += "'\\''";
    } else {
      word += letter;
    }
  }
  return word + "'";
}

std::string one_line(const std::string& message) {
  std::istringstream lines(message);
  std::string joined;
  for (std::string line; std::getline(lines, line);) {
    if (const auto prefix = line.find("error: "); prefix != std::string::npos) {
      line.erase(0, prefix + std::string_view("error: ").size());
    }
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    joined += (joined.empty() ? "" : "; ") + line;
  }
  return joined.empty() ? "it said nothing" : joined;
}

}  // namespace occlab
