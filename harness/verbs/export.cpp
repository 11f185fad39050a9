#include <fmt/format.h>

#include <filesystem>
#include <string>

#include "harness/blender.h"
#include "harness/verbs/verbs.h"
#include "renderers/scene/data_root.h"
#include "renderers/scene/error.h"
#include "renderers/scene/scene.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

struct ExportOptions {
  std::string blend;
  std::string output;
  std::string blender = "blender";
};

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
                  run_blender(find_blender(options.blender),
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
