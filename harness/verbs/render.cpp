#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>

#include "harness/verbs/verbs.h"
#include "harness/workbench.h"
#include "renderers/methods/fact_warnings.h"
#include "renderers/methods/method.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

struct RenderOptions {
  ViewSettings view;
  ProbeSettings probe;
  std::string method;
  std::vector<std::string> settings;
  std::vector<int> resolution = {1280, 720};
  std::string device = "auto";
  std::string output;
};

ParameterSet parse_settings(const MethodInfo& method, const std::vector<std::string>& settings) {
  ParameterSet parameters(method.parameters);
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos) {
      throw InputError(fmt::format("--set {}: accepted is NAME=VALUE", setting));
    }
    try {
      parameters.set_text(setting.substr(0, equals), setting.substr(equals + 1));
    } catch (const InputError& error) {
      throw InputError(fmt::format("--set {}: {}", setting, error.what()));
    }
  }
  return parameters;
}

/// Said before the rendering, which may take minutes, and not after it.
void check_output(const std::string& output) {
  if (!output.ends_with(".exr")) {
    throw InputError(fmt::format("-o {}: accepted is a path that ends in .exr", output));
  }
  const std::filesystem::path folder = std::filesystem::absolute(output).parent_path();
  if (::access(folder.c_str(), W_OK | X_OK) != 0 || !std::filesystem::is_directory(folder)) {
    throw DeviceError(fmt::format("-o {}: cannot be written: {}: {}", output, folder.string(),
                                  std::strerror(errno != 0 ? errno : ENOTDIR)));
  }
}

void print_warnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) fmt::print(stderr, "occlab: {}\n", warning);
}

int render(RenderOptions options) {
  const MethodInfo& method = find_method(options.method);
  const ParameterSet parameters = parse_settings(method, options.settings);
  check_output(options.output);
  options.view.width = options.resolution[0];
  options.view.height = options.resolution[1];
  if (!options.probe.source.empty()) options.view.probe = options.probe;

  Workbench bench(options.view, options.device);
  print_warnings(bench.warnings());
  const auto start = std::chrono::steady_clock::now();
  Metadata facts;
  Layers layers = method.make()->evaluate(bench.frame(), parameters, facts);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  print_warnings(fact_warnings(parameters, facts));
  layers.add("mask", bench.frame().surface().mask);

  Metadata metadata = {{"occlab:method", method.name},
                       {"occlab:parameters", parameters.to_string()},
                       {"occlab:scene", bench.scene().path.filename().string()},
                       {"occlab:view", bench.frame().view.camera.name},
                       {"occlab:probe", describe(bench.probe())},
                       {"occlab:device", bench.device().renderer},
                       {"occlab:driver", bench.device().version}};
  for (const auto& [name, value] : facts) metadata["occlab:" + name] = value;
  write_exr(options.output, layers, metadata);
  fmt::print("{}: {} on {} in {:.2f} s, first use included\n", options.output, method.title,
             bench.device().renderer, elapsed.count());
  return exit_good;
}

}  // namespace

void add_render_verb(CLI::App& app, Action& action) {
  auto options = std::make_shared<RenderOptions>();
  CLI::App* verb = app.add_subcommand("render", "render one view with one method into an EXR");
  verb->add_option("--scene", options->view.scene, "a scene's name, or a .glb or .gltf")
      ->required();
  verb->add_option("--view", options->view.view, "a camera's name; default: the first");
  verb->add_option("--resolution", options->resolution, "width and height in pixels")
      ->expected(2)
      ->check(CLI::Range(1, 16384));
  verb->add_option("--probe", options->probe.source,
                   "a probe's name, or an equirect .exr or .hdr; default: the scene's own");
  verb->add_option("--rotation", options->probe.rotation_degrees,
                   "turns the probe counter-clockwise from above, degrees");
  verb->add_option("--exposure", options->probe.exposure_stops, "probe times 2^stops");
  verb->add_option("--prefilter", options->probe.prefilter_degrees,
                   "sigma of a Gaussian over the probe, degrees");
  verb->add_option("--method", options->method, "see 'occlab list methods'")->required();
  verb->add_option("--set", options->settings, "NAME=VALUE of a parameter of the method");
  verb->add_option("--device", options->device, "see 'occlab list devices'")->capture_default_str();
  verb->add_option("-o,--output", options->output, "the EXR to write")->required();
  verb->callback([options, &action] { action = [options] { return render(*options); }; });
}

}  // namespace occlab
