#include "harness/verify/cycles_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "harness/blender.h"
#include "harness/files.h"
#include "harness/verify/cycles_comparison.h"
#include "harness/verify/cycles_render.h"
#include "harness/verify/cycles_verdicts.h"
#include "renderers/scene/error.h"
#include "renderers/scene/image_io.h"
#include "renderers/scene/temporary_folder.h"
#include "renderers/trace/reference.h"

namespace occlab {
namespace fs = std::filesystem;
namespace {

constexpr double aimed_time_ratio = 5.0;

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
  long ao_rays_per_seed = 0;  ///< a pixel
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
    ours.ao.seconds += seconds_of([&] {
      Reference traced = trace(dark, how);
      ours.ao_rays_per_seed = traced.rays_per_pixel;
      ours.ao.images.push_back(std::move(traced.ambient_occlusion));
    });
  }
  return ours;
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
          .expected = aimed_time_ratio,
          .bound = std::numeric_limits<double>::infinity(),
          .rule = fmt::format("aimed at, not judged: to {:.2f}% RMS error RTDO takes {:.2f} s, "
                              "Cycles {:.2f} s; before that, BVH and so on, {:.2f} s and {:.2f} s",
                              100.0 * comparison.rms_error_b, our_seconds, theirs.seconds,
                              ours.prepare_seconds, theirs.prepare_seconds),
          .passes = true,
          .detail = fmt::format("RTDO rendered {:.2f} s to {:.3f}%", ours.seconds,
                                100.0 * comparison.rms_error_a)};
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

  TemporaryFolder scratch("occlab-cycles-");
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
  const RendererComparison ao = compare_renderers(
      ours.ao.images, cycles.ao.images, mask,
      {.a = ours.ao_rays_per_seed, .b = for_each_seed(settings.samples, settings.seeds)});

  const std::string place = fmt::format("{} {}", bench.scene().name, frame.view.camera.name);
  const std::string lit = fmt::format("{}, {}", place, describe(bench.probe()));
  const std::string occluded =
      fmt::format("{}, k_A within {:g}", place, settings.ao_distance_world);
  Checks checks = judge_comparison(light, lit);
  if (!bench.scene().textures.empty()) {
    for (Check& check : checks) {
      check.detail +=
          "; between texels Cycles mixes sRGB, we what it stands for; nearest texels are the same";
    }
  }
  const bool masked = std::ranges::any_of(
      bench.scene().materials, [](const Material& m) { return m.alpha_cutoff.has_value(); });
  for (Check& check : judge_comparison(ao, occluded)) {
    if (masked) check.detail += "; to Cycles' AO node the holes of alpha masks are blockers";
    checks.push_back(std::move(check));
  }
  checks.push_back(time_check(light, ours.light, cycles.light, lit));

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
