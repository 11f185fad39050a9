#include "harness/verify/cycles_render.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>

#include "harness/blender.h"
#include "harness/files.h"
#include "renderers/scene/data_root.h"
#include "renderers/scene/error.h"
#include "renderers/scene/image_io.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

void write_job(const CyclesJob& job, const fs::path& folder, const fs::path& path) {
  // The texels that ours looks up, prefilter and exposure applied.
  const fs::path probe = folder / "probe.exr";
  Layers texels;
  texels.add("", job.environment.texels);
  write_exr(probe, texels, {});

  std::vector<int> seeds(std::size_t(job.seeds));
  std::iota(seeds.begin(), seeds.end(), 1);
  const nlohmann::json description = {
      {"scene", fs::absolute(job.scene).string()},
      {"camera", job.view.camera.name},
      {"width", job.view.width},
      {"height", job.view.height},
      {"seeds", seeds},
      {"output", folder.string()},
      {"light",
       {{"probe", probe.string()},
        {"rotation_degrees", job.rotation_degrees},
        {"samples", job.samples_per_seed}}},
      {"ao", {{"distance", job.ao_distance_world}, {"samples", job.samples_per_seed}}}};
  write_text_atomically(path, description.dump(2));
}

/// The script's reason if it gave one, else the last line of the log that says something.
std::string last_words(const fs::path& log) {
  std::istringstream lines(read_text(log));
  std::string last = "it said nothing";
  const std::string marker = "occlab cycles: error: ";
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(marker)) return line.substr(marker.size());
    if (!line.empty() && line != "Blender quit") last = line;
  }
  return last;
}

void check_image(const Image& image, const View& view, const fs::path& path) {
  if (image.width() != view.width || image.height() != view.height) {
    throw DeviceError(fmt::format("{}: Cycles' image is {}x{}; asked for was {}x{}", path.string(),
                                  image.width(), image.height(), view.width, view.height));
  }
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (const float value : image.pixel(x, y)) {
        if (!std::isfinite(value)) {
          throw DeviceError(fmt::format("{}: Cycles' image has the value {} at pixel ({}, {})",
                                        path.string(), value, x, y));
        }
      }
    }
  }
}

Image first_channel(const Image& image) {
  Image result(image.width(), image.height(), 1);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) result.at(x, y) = image.at(x, y, 0);
  }
  return result;
}

SeededRendering read_images(const CyclesJob& job, const fs::path& folder, const std::string& kind,
                            const nlohmann::json& times) {
  SeededRendering rendering;
  for (int seed = 1; seed <= job.seeds; ++seed) {
    const fs::path path = folder / fmt::format("{}_{}.exr", kind, seed);
    if (!fs::exists(path)) throw DeviceError(fmt::format("{}: Cycles wrote none", path.string()));
    rendering.images.push_back(read_rgb(path));
    check_image(rendering.images.back(), job.view, path);
  }
  for (const double seconds : times.at("seconds")) rendering.seconds += seconds;
  for (const double seconds : times.at("prepare_seconds")) {
    rendering.prepare_seconds += seconds / job.seeds;
  }
  return rendering;
}

void run_script(const CyclesJob& job, const fs::path& folder) {
  const fs::path description = folder / "job.json";
  const fs::path log = folder / "cycles.log";
  write_job(job, folder, description);
  const fs::path script = data_root() / "scenes" / "cycles.py";
  const int code = run_blender(job.blender,
                               {"--background", "--factory-startup", "--python-exit-code", "3",
                                "--python", script.string(), "--", description.string()},
                               log);
  if (code == exit_bad_input) {
    throw InputError(fmt::format("Cycles cannot render this: {}", last_words(log)));
  }
  if (code != 0) {
    throw DeviceError(fmt::format("{}: scenes/cycles.py failed (exit code {}): {}",
                                  job.blender.string(), code, last_words(log)));
  }
}

}  // namespace

CyclesRendering render_with_cycles(const CyclesJob& job, const fs::path& folder) {
  run_script(job, folder);
  const fs::path report = folder / "cycles.json";
  if (!fs::exists(report)) {
    throw DeviceError(fmt::format("{}: Blender ended without writing it", report.string()));
  }
  try {
    const nlohmann::json said = nlohmann::json::parse(read_text(report));
    CyclesRendering rendering{.version = said.at("version").get<std::string>(),
                              .light = read_images(job, folder, "light", said.at("light")),
                              .ao = read_images(job, folder, "ao", said.at("ao"))};
    for (Image& image : rendering.ao.images) image = first_channel(image);
    return rendering;
  } catch (const nlohmann::json::exception& error) {
    throw DeviceError(fmt::format("{}: {}", report.string(), error.what()));
  } catch (const InputError& error) {  // it is not the user who wrote these files
    throw DeviceError(error.what());
  }
}

}  // namespace occlab
