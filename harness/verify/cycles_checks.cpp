#include "harness/verify/cycles_checks.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "harness/blender.h"
#include "harness/files.h"
#include "harness/statistics.h"
#include "harness/verify/cycles_comparison.h"
#include "harness/verify/cycles_render.h"
#include "renderers/scene/error.h"
#include "renderers/scene/image_io.h"
#include "renderers/trace/reference.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

constexpr double accepted_block_difference = 0.005;
constexpr double share_false_alarms = 1e-6;

void require_settings(const CyclesSettings& settings) {
  const auto require = [](bool good, std::string_view key, auto found, std::string_view accepted) {
    if (!good) {
      throw InputError(fmt::format("verify cycles: {} {}; accepted: {}", key, found, accepted));
    }
  };
  require(settings.samples >= 1, "samples", settings.samples, "1 or more");
  require(settings.rays_per_pixel >= 1, "rays per pixel", settings.rays_per_pixel, "1 or more");
  require(settings.seeds >= 4 && settings.seeds <= 64, "seeds", settings.seeds, "4 to 64");
  require(std::isfinite(settings.ao_distance_world) && settings.ao_distance_world > 0.0,
          "distance of the ambient occlusion", settings.ao_distance_world,
          "a number of scene units above 0");
  require(settings.view.width >= 1 && settings.view.height >= 1, "resolution",
          fmt::format("{}x{}", settings.view.width, settings.view.height), "1x1 or more");
}

/// A fresh folder, gone with its content at the end unless it is to be kept.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (fs::temp_directory_path() / "occlab-cycles-XXXXXX").string();
    if (!mkdtemp(name.data())) throw DeviceError(fmt::format("{}: cannot be created", name));
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    if (!kept_) fs::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const fs::path& path() const { return path_; }
  void keep() { kept_ = true; }

 private:
  fs::path path_;
  bool kept_ = false;
};

long for_each_seed(long all, int seeds) { return (all + seeds - 1) / seeds; }

double seconds_of(const auto& run) {
  const auto start = std::chrono::steady_clock::now();
  run();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Our renderings: radiance at unlimited distance, and k_A within the distance.
struct OurRendering {
  SeededRendering light;
  SeededRendering ao;
};

OurRendering render_ours(const CyclesSettings& settings, const Frame& frame) {
  const auto trace = [&](const Environment& environment, const TraceSettings& how) {
    const GBufferImages& surface = frame.surface();
    return trace_reference(frame.traced(), environment, {}, frame.view,
                           {surface.position_view, surface.normal_view,
                            surface.geometric_normal_view, surface.albedo, surface.mask},
                           how);
  };
  OurRendering ours;
  ours.light.prepare_seconds = ours.ao.prepare_seconds = seconds_of([&] {
    frame.surface();
    frame.traced();
  });
  const Environment dark = constant_environment(glm::vec3(0.0f));
  for (int seed = 1; seed <= settings.seeds; ++seed) {
    TraceSettings how{.rays_per_pixel = for_each_seed(settings.rays_per_pixel, settings.seeds),
                      .seed = std::uint64_t(seed)};
    ours.light.seconds += seconds_of(
        [&] { ours.light.images.push_back(trace(frame.lighting.environment(), how).radiance); });
    how.estimator = Estimator::cosine;
    how.d_max_world = float(settings.ao_distance_world);
    ours.ao.seconds +=
        seconds_of([&] { ours.ao.images.push_back(trace(dark, how).ambient_occlusion); });
  }
  return ours;
}

std::string channel_name(const RendererComparison& comparison, int channel) {
  if (comparison.z.channels() == 1) return "";
  return fmt::format(" of {}", std::vector{"red", "green", "blue"}[std::size_t(channel)]);
}

std::string percent(const BlockDifference& block) {
  return fmt::format("{:+.3f}% +- {:.3f}%", 100.0 * block.difference, 100.0 * block.error);
}

Check block_check(const RendererComparison& comparison, const std::string& name) {
  if (comparison.blocks.empty()) {
    throw InputError(
        fmt::format("verify cycles: no 64x64 block has {} pixels away from silhouettes; render "
                    "more pixels",
                    min_block_pixels));
  }
  const BlockDifference& worst =
      *std::ranges::max_element(comparison.blocks, {}, &BlockDifference::limit);
  const auto count = comparison.blocks.size() / std::size_t(comparison.z.channels());
  Check check = checked({.subject = "cycles",
                         .name = name,
                         .quantity = "worst 64x64 block: |ours / Cycles - 1| + its error",
                         .measured = worst.limit(),
                         .expected = 0.0,
                         .bound = accepted_block_difference,
                         .rule = "0.5%, at the far end of the block's 95% interval",
                         .detail = {}});
  const bool unresolved = !check.passes && std::abs(worst.difference) <= check.bound;
  check.detail =
      fmt::format("{}{}{}, block at ({}, {}), {} pixels; {} blocks, {} left out with fewer than {}",
                  unresolved ? "could not resolve 0.5%, give more samples: " : "", percent(worst),
                  channel_name(comparison, worst.channel), worst.x, worst.y, worst.pixels, count,
                  comparison.blocks_left_out, min_block_pixels);
  return check;
}

Check mean_check(const RendererComparison& comparison, const std::string& name) {
  return checked({.subject = "cycles",
                  .name = name,
                  .quantity = "whole picture: |ours / Cycles - 1| + its error",
                  .measured = comparison.whole.limit(),
                  .expected = 0.0,
                  .bound = accepted_block_difference,
                  .rule = "0.5%, at the far end of the 95% interval",
                  .detail = fmt::format("{}{}", percent(comparison.whole),
                                        channel_name(comparison, comparison.whole.channel))});
}

Check share_check(const RendererComparison& comparison, const std::string& name) {
  const double expected = 2.0 * normal_cdf(-3.0);
  const double error = std::sqrt(expected * (1.0 - expected) / comparison.independent_pixels);
  Check check{.subject = "cycles",
              .name = name,
              .quantity = "share of pixels beyond 3 sigma",
              .measured = comparison.share_beyond_3_sigma,
              .expected = expected,
              .bound = -normal_quantile(share_false_alarms) * error,
              .rule = "no more than noise gives; false alarms 1e-6",
              .detail = {}};
  check.passes = check.measured <= check.expected + check.bound;  // fewer are no fault
  const auto worst =
      std::ranges::max_element(comparison.z.values(), {}, [](float z) { return std::abs(z); }) -
      comparison.z.values().begin();
  const auto pixel = worst / comparison.z.channels();
  check.detail = fmt::format("{} pixels; largest z {:+.1f} at ({}, {})", comparison.pixels,
                             comparison.z.values()[std::size_t(worst)],
                             pixel % comparison.z.width(), pixel / comparison.z.width());
  return check;
}

/// The variance of a mean over seeds falls exactly as their number grows, so that the time to an
/// error follows from the time and the error of what was rendered.
Check time_check(const RendererComparison& comparison, const SeededRendering& ours,
                 const SeededRendering& theirs, const std::string& name) {
  const double errors = comparison.rms_error_a / comparison.rms_error_b;
  const double our_seconds = ours.seconds * errors * errors;
  return {.subject = "cycles",
          .name = name,
          .quantity = "equal-error time: Cycles / RTDO",
          .measured = theirs.seconds / our_seconds,
          .expected = 5.0,
          .bound = std::numeric_limits<double>::infinity(),
          .rule = "reported, not judged",
          .passes = true,
          .detail = fmt::format(
              "RTDO {:.2f} s, Cycles {:.2f} s to {:.3f}% RMS standard error; before that {:.2f} s "
              "and {:.2f} s; rendered: RTDO {:.2f} s to {:.3f}%",
              our_seconds, theirs.seconds, 100.0 * comparison.rms_error_b, ours.prepare_seconds,
              theirs.prepare_seconds, ours.seconds, 100.0 * comparison.rms_error_a)};
}

void write_images(const fs::path& path, const RendererComparison& comparison, const Image& mask) {
  Layers layers;
  layers.add("ours", comparison.mean_a);
  layers.add("cycles", comparison.mean_b);
  layers.add("relative_difference", comparison.relative_difference);
  layers.add("z", comparison.z);
  layers.add("compared", mask);
  write_exr(path, layers, {});
}

}  // namespace

Checks verify_cycles(const CyclesSettings& settings) {
  require_settings(settings);
  const fs::path blender = find_blender(settings.blender);
  Workbench bench(settings.view, settings.device);
  if (bench.probe().source.empty()) {
    throw InputError(fmt::format("verify cycles: {}: no environment lights it; name a probe",
                                 bench.scene().path.string()));
  }
  if (!settings.output.empty()) create_folder(settings.output);
  const Frame& frame = bench.frame();

  ScratchFolder scratch;
  const CyclesRendering cycles =
      render_with_cycles({.scene = bench.scene().path,
                          .view = frame.view,
                          .environment = frame.lighting.environment(),
                          .rotation_degrees = bench.probe().rotation_degrees,
                          .ao_distance_world = settings.ao_distance_world,
                          .samples_per_seed = for_each_seed(settings.samples, settings.seeds),
                          .seeds = settings.seeds,
                          .blender = blender},
                         scratch.path());
  const OurRendering ours = render_ours(settings, frame);

  const GBufferImages& surface = frame.surface();
  const Image mask =
      away_from_silhouettes(surface.position_view, surface.geometric_normal_view, surface.mask);
  const RendererComparison light = compare_renderers(ours.light.images, cycles.light.images, mask);
  const RendererComparison ao = compare_renderers(ours.ao.images, cycles.ao.images, mask);

  const std::string place = fmt::format("{} {}", bench.scene().name, frame.view.camera.name);
  const std::string lit = fmt::format("{}, {}", place, describe(bench.probe()));
  const std::string occluded =
      fmt::format("{}, k_A within {:g}", place, settings.ao_distance_world);
  Checks checks = {block_check(light, lit),
                   share_check(light, lit),
                   mean_check(light, lit),
                   block_check(ao, occluded),
                   share_check(ao, occluded),
                   mean_check(ao, occluded),
                   time_check(light, ours.light, cycles.light, lit)};

  const bool failed = !std::ranges::all_of(checks, &Check::passes);
  if (failed || !settings.output.empty()) {
    const fs::path folder = settings.output.empty() ? scratch.path() : settings.output;
    write_images(folder / "cycles_light.exr", light, mask);
    write_images(folder / "cycles_ao.exr", ao, mask);
    if (settings.output.empty()) scratch.keep();
    for (Check& check : checks) {
      if (!check.passes) check.detail += fmt::format("; images in {}", folder.string());
    }
  }
  return checks;
}

}  // namespace occlab
