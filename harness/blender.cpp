#include "harness/blender.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <string_view>
#include <thread>

#include "harness/spawn.h"
#include "renderers/scene/error.h"
#include "renderers/scene/interrupt.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

std::vector<std::string> environment_for(const fs::path& program) {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable; ++variable) {
    if (!std::string_view(*variable).starts_with("PATH=")) variables.emplace_back(*variable);
  }
  variables.push_back(fmt::format("PATH={}:{}", program.parent_path().string(), search_path()));
  return variables;
}

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
  if (name.find('/') != std::string::npos) {
    if (is_program(name)) return fs::canonical(name);
    throw InputError(fmt::format("--blender {}: no such program", name));
  }
  if (const auto found = find_on_path(name)) return fs::canonical(*found);
  throw InputError(
      fmt::format("--blender {}: not on the PATH; Debian has it as the package blender", name));
}

int run_blender(const fs::path& blender, std::vector<std::string> arguments, const fs::path& log) {
  arguments.insert(arguments.begin(), blender.string());
  std::vector<std::string> environment = environment_for(blender);
  SpawnActions actions;
  if (!log.empty()) {
    actions.open(STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC);
    actions.duplicate(STDOUT_FILENO, STDERR_FILENO);
  }
  pid_t child = 0;
  const int error = posix_spawn(&child, blender.c_str(), actions.get(), nullptr,
                                spawn_words(arguments).data(), spawn_words(environment).data());
  if (error != 0) {
    throw DeviceError(
        fmt::format("{}: cannot be started: {}", blender.string(), std::strerror(error)));
  }
  const int status = wait_for(child);
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  throw DeviceError(fmt::format("{}: ended by signal {}", blender.string(), WTERMSIG(status)));
}

}  // namespace occlab
