#include "harness/history/git.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>

#include "harness/history/run_data.h"
#include "renderers/scene/error.h"

namespace occlab::history {
namespace {

/// A pipe whose ends close on every way out.
class Pipe {
 public:
  Pipe() {
    if (::pipe2(ends_.data(), O_CLOEXEC) != 0) throw DeviceError("no pipe: too many open files");
  }
  ~Pipe() {
    close(0);
    close(1);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  int end(std::size_t index) const { return ends_[index]; }
  void close(std::size_t index) {
    if (ends_[index] >= 0) ::close(ends_[index]);
    ends_[index] = -1;
  }

 private:
  std::array<int, 2> ends_ = {-1, -1};
};

std::string read_all(int descriptor) {
  std::string text;
  std::array<char, 4096> block{};
  for (;;) {
    const ssize_t size = ::read(descriptor, block.data(), block.size());
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return text;
    text.append(block.data(), std::size_t(size));
  }
}

std::string without_line_end(std::string text) {
  while (text.ends_with('\n')) text.pop_back();
  return text;
}

}  // namespace

std::optional<std::string> git(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "git");
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  Pipe pipe;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, pipe.end(1), STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int error = posix_spawnp(&child, "git", &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return std::nullopt;
  pipe.close(1);
  std::string text = read_all(pipe.end(0));
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return std::nullopt;
  return without_line_end(std::move(text));
}

std::optional<Commit> find_commit(const std::string& revision) {
  const auto hash =
      git({"rev-parse", "--verify", "--quiet", "--end-of-options", revision + "^{commit}"});
  if (!hash) return std::nullopt;
  const auto subject = git({"show", "-s", "--format=%s", *hash});
  const auto time = git({"show", "-s", "--format=%cI", *hash});
  if (!subject || !time) return std::nullopt;
  return Commit{*hash, *subject, utc_time(*time, "git's time of " + *hash)};
}

std::string current_user() {
  const auto name = git({"config", "user.name"});
  const auto mail = git({"config", "user.email"});
  if (name && !name->empty()) {
    return mail && !mail->empty() ? fmt::format("{} <{}>", *name, *mail) : *name;
  }
  const char* const user = std::getenv("USER");
  return user && *user != '\0' ? user : "unknown";
}

}  // namespace occlab::history
