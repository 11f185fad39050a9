#include "harness/blender.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <string_view>
#include <thread>

#include "renderers/scene/error.h"
#include "renderers/scene/interrupt.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

std::string search_path() {
  const char* path = std::getenv("PATH");
  return path ? path : "/usr/local/bin:/usr/bin:/bin";
}

std::vector<std::string> environment_for(const fs::path& program) {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable; ++variable) {
    if (!std::string_view(*variable).starts_with("PATH=")) variables.emplace_back(*variable);
  }
  variables.push_back(fmt::format("PATH={}:{}", program.parent_path().string(), search_path()));
  return variables;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> all;
  for (std::string& text : texts) all.push_back(text.data());
  all.push_back(nullptr);
  return all;
}

/// Where the child's output goes.
class FileActions {
 public:
  explicit FileActions(const fs::path& log) {
    posix_spawn_file_actions_init(&actions_);
    if (log.empty()) return;
    posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, log.c_str(),
                                     O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_adddup2(&actions_, STDOUT_FILENO, STDERR_FILENO);
  }
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_;
};

/// The child's wait status. Polls, so that a signal to this program alone ends the child, too:
/// waitpid is restarted after signals.
int wait_for(pid_t child) {
  int status = 0;
  bool asked_to_end = false;
  while (waitpid(child, &status, WNOHANG) == 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    try {
      throw_if_interrupted();
    } catch (const Interrupted&) {
      if (!asked_to_end) kill(child, SIGTERM);
      asked_to_end = true;
    }
  }
  throw_if_interrupted();
  return status;
}

}  // namespace

fs::path find_blender(const std::string& name) {
  const auto runs = [](const fs::path& file) {
    return fs::is_regular_file(file) && ::access(file.c_str(), X_OK) == 0;
  };
  if (name.find('/') != std::string::npos) {
    if (runs(name)) return fs::canonical(name);
    throw InputError(fmt::format("--blender {}: no such program", name));
  }
  std::istringstream folders(search_path());
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (runs(fs::path(folder) / name)) return fs::canonical(fs::path(folder) / name);
  }
  throw InputError(
      fmt::format("--blender {}: not on the PATH; Debian has it as the package blender", name));
}

int run_blender(const fs::path& blender, std::vector<std::string> arguments, const fs::path& log) {
  arguments.insert(arguments.begin(), blender.string());
  std::vector<std::string> environment = environment_for(blender);
  const FileActions actions(log);
  pid_t child = 0;
  const int error = posix_spawn(&child, blender.c_str(), actions.get(), nullptr,
                                pointers(arguments).data(), pointers(environment).data());
  if (error != 0) {
    throw DeviceError(
        fmt::format("{}: cannot be started: {}", blender.string(), std::strerror(error)));
  }
  const int status = wait_for(child);
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  throw DeviceError(fmt::format("{}: ended by signal {}", blender.string(), WTERMSIG(status)));
}

}  // namespace occlab
