// load_environment: OpenEXR and Radiance files, by their first bytes.
#include <algorithm>
#include <cmath>

#include "renderers/scene/environment.h"
#include "renderers/scene/error.h"
#include "renderers/scene/limits.h"
#include "renderers/scene/parallel.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace occlab;
  static const fuzz::Folder folder;
  static const bool set_up = [] {
    set_thread_count(1);
    set_limits("probe_pixels=32768,image_channels=64,image_bytes=8388608");
    return true;
  }();
  const auto file = folder.write("probe.exr", fuzz::text_of(data, size));
  try {
    const Environment environment = load_environment({.source = file.string()});
    fuzz::require(set_up && environment.texels.width() == 2 * environment.texels.height());
    fuzz::require(std::ranges::all_of(environment.texels.values(), [](float value) {
      return std::isfinite(value) && value >= 0.0f;
    }));
    const EnvironmentSampler sampler(environment);
    if (!sampler.black()) fuzz::require(sampler.sample(0.5f, 0.5f).pdf > 0.0f);
  } catch (const InputError&) {
  }
  return 0;
}
