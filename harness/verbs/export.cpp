#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "harness/verbs/verbs.h"
#include "renderers/scene/data_root.h"
#include "renderers/scene/error.h"
#include "renderers/scene/interrupt.h"
#include "renderers/scene/scene.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

struct ExportOptions {
  std::string blend;
  std::string output;
  std::string blender = "blender";
};

std::string search_path() {
  const char* path = std::getenv("PATH");
  return path ? path : "/usr/local/bin:/usr/bin:/bin";
}

/// The file that a shell would start for `name`, symbolic links followed.
fs::path find_program(const std::string& name) {
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

/// This process's environment with the program's own folder first on the PATH: Debian's Blender
/// takes its Python modules from beside the first python3 there, and those of a virtual environment
/// or of pyenv lack the numpy that its glTF exporter needs.
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

/// Runs a program without a shell; returns its exit code.
int run_program(const fs::path& program, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), program.string());
  std::vector<std::string> environment = environment_for(program);
  pid_t child = 0;
  const int error = posix_spawn(&child, program.c_str(), nullptr, nullptr,
                                pointers(arguments).data(), pointers(environment).data());
  if (error != 0) {
    throw DeviceError(
        fmt::format("{}: cannot be started: {}", program.string(), std::strerror(error)));
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  throw_if_interrupted();
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  throw DeviceError(fmt::format("{}: ended by signal {}", program.string(), WTERMSIG(status)));
}

/// The exit codes are those of scenes/export.py (scenes/FORMAT.md) and of Blender itself.
void check_exit_code(const std::string& blend, int code) {
  switch (code) {
    case 0:
      return;
    case 1:
      throw InputError(fmt::format("{}: Blender cannot open it; accepted is a .blend file", blend));
    case 2:
      throw InputError(fmt::format(
          "{}: not exported, for the reasons above; scenes/FORMAT.md says what is accepted",
          blend));
    default:
      throw DeviceError(fmt::format(
          "{}: not exported: the export script failed in Blender (exit code {}), as above", blend,
          code));
  }
}

int export_scene(const ExportOptions& options) {
  if (!fs::is_regular_file(options.blend)) {
    throw InputError(fmt::format("{}: no such file", options.blend));
  }
  if (!options.output.ends_with(".glb")) {
    throw InputError(fmt::format("-o {}: accepted is a path that ends in .glb", options.output));
  }
  const fs::path script = data_root() / "scenes" / "export.py";
  check_exit_code(options.blend,
                  run_program(find_program(options.blender),
                              {"--background", "--factory-startup", "--python-exit-code", "3",
                               fs::absolute(options.blend).string(), "--python", script.string(),
                               "--", fs::absolute(options.output).string()}));
  const Scene scene = load_scene(options.output);
  fmt::print("{}: {} views, {} triangles, {} lights\n", options.output, scene.cameras.size(),
             scene.triangle_count(), scene.lights.size());
  for (const std::string& warning : scene.warnings) fmt::print("  {}\n", warning);
  return exit_good;
}

}  // namespace

void add_export_verb(CLI::App& app, Action& action) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* verb = app.add_subcommand(
      "export", "export a .blend to the .glb that occlab loads (scenes/FORMAT.md); needs Blender");
  verb->add_option("blend", options->blend, "the .blend file")->required();
  verb->add_option("-o,--output", options->output, "the .glb to write")->required();
  verb->add_option("--blender", options->blender, "the Blender to run")->capture_default_str();
  verb->callback([options, &action] { action = [options] { return export_scene(*options); }; });
}

}  // namespace occlab
