#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cstring>
#include <filesystem>

#include "harness/verbs/verbs.h"
#include "renderers/scene/data_root.h"
#include "renderers/scene/error.h"
#include "renderers/scene/scene.h"

extern char** environ;

namespace occlab {
namespace fs = std::filesystem;
namespace {

struct ExportOptions {
  std::string blend;
  std::string output;
  std::string blender = "blender";
};

/// Runs a program without a shell; returns its exit code.
int run_program(const std::vector<std::string>& arguments) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  pid_t child = 0;
  const int error = posix_spawnp(&child, argv[0], nullptr, nullptr, argv.data(), environ);
  if (error == ENOENT) {
    throw InputError(
        fmt::format("'{}' is not on the PATH; Debian has it as the package blender, or "
                    "name it with --blender",
                    arguments.front()));
  }
  if (error != 0) {
    throw DeviceError(
        fmt::format("{} cannot be started: {}", arguments.front(), std::strerror(error)));
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

int export_scene(const ExportOptions& options) {
  if (!fs::is_regular_file(options.blend)) {
    throw InputError(fmt::format("{}: no such file", options.blend));
  }
  if (!options.output.ends_with(".glb")) {
    throw InputError(fmt::format("-o {}: accepted is a path that ends in .glb", options.output));
  }
  const fs::path script = data_root() / "scenes" / "export.py";
  const int code =
      run_program({options.blender, "--background", "--factory-startup", "--python-exit-code", "3",
                   fs::absolute(options.blend).string(), "--python", script.string(), "--",
                   fs::absolute(options.output).string()});
  if (code != 0) {
    throw InputError(
        fmt::format("{}: Blender did not export it (its exit code is {}); its message "
                    "is above",
                    options.blend, code));
  }
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
