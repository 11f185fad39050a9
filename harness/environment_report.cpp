#include "harness/environment_report.h"

#include <embree3/rtcore_config.h>
#include <fmt/format.h>

#include <glm/glm.hpp>

#include "harness/version.h"
#include "renderers/scene/image_io.h"

namespace occlab {

nlohmann::json environment_report(const Experiment& experiment, const Workbench& bench) {
  const Scene& scene = bench.scene();
  nlohmann::json seeds = nlohmann::json::array();
  for (const RunSettings& run : experiment.runs) {
    seeds.push_back(
        {{"methods", run.methods}, {"first", run.seeds.front()}, {"last", run.seeds.back()}});
  }
  return {
      {"schema", 1},
      {"experiment", experiment.name},
      {"title", experiment.title},
      {"configuration", experiment.resolved},
      {"commit", build_commit},
      {"code", {{"renderers", renderers_hash}, {"harness", harness_hash}}},
      {"device",
       {{"id", bench.device().id},
        {"vendor", bench.device().vendor},
        {"renderer", bench.device().renderer},
        {"driver", bench.device().version},
        {"rasteriser", bench.device().software ? "software" : "hardware"}}},
      {"libraries",
       {{"embree", RTC_VERSION_STRING},
        {"glm", fmt::format("{}.{}.{}", GLM_VERSION_MAJOR, GLM_VERSION_MINOR, GLM_VERSION_PATCH)},
        {"openimageio", image_library_version()},
        {"compiler", __VERSION__}}},
      {"scene",
       {{"name", scene.name},
        {"sha256", bench.scene_hash()},
        {"triangles", scene.triangle_count()},
        {"bounding_radius", scene.bounding_radius()}}},
      {"view", bench.frame().view.camera.name},
      {"resolution", {experiment.scene.width, experiment.scene.height}},
      {"probe", {{"description", describe(bench.probe())}, {"sha256", bench.probe_hash()}}},
      {"seeds", seeds},
  };
}

}  // namespace occlab
