// load_experiment: TOML and every rule of the experiment file. After the first NUL a line is one
// --set.
#include "harness/config.h"
#include "harness/error_budget.h"
#include "renderers/methods/method.h"
#include "renderers/scene/error.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace occlab;

/// Methods with every kind of parameter, none of which renders: the rules are what is tested.
std::vector<MethodInfo> make_methods() {
  const std::vector<Parameter> screen = {
      integer_parameter("samples", 32, 1, 256, "", ""),
      integer_parameter("steps", 2, 1, 64, "", ""), seed_parameter(""),
      real_parameter("d_max_world", 1.0, 1e-6, 1e6, "scene units", ""),
      choice_parameter("weight", {"binary", "lambda"}, "")};
  const std::vector<Parameter> traced = {
      integer_parameter("rays_per_pixel", 1024, 1, 1 << 20, "", ""), seed_parameter(""),
      real_parameter("d_max_world", 1.0, 1e-6, 1e6, "scene units", "")};
  std::vector<MethodInfo> methods(4);
  methods[0].name = "ssao";
  methods[0].parameters = screen;
  methods[1].name = "s3ho";
  methods[1].parameters = screen;
  methods[2].name = "rtdo";
  methods[2].parameters = traced;
  methods[3].name = "fixed";
  return methods;
}

}  // namespace

/// In the program it asks for the method's representation (error_budget.cpp), which would link all
/// passes into the fuzzer.
bool occlab::has_budget(const PlannedCell& cell) { return cell.method == "ssao"; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::vector<MethodInfo> methods = make_methods();
  static const fuzz::Folder folder;
  const fuzz::TwoParts parts = fuzz::split(fuzz::text_of(data, size));
  const auto file = folder.write("experiment.toml", parts.first);
  std::vector<std::string> overrides;
  if (!parts.second.empty()) overrides.emplace_back(parts.second);
  try {
    const Experiment experiment = load_experiment(file, overrides, methods);
    fuzz::require(!experiment.name.empty() && !experiment.resolved.empty());
  } catch (const InputError&) {
  }
  return 0;
}
