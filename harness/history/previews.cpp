#include "harness/history/previews.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "harness/figures/shrink.h"
#include "harness/figures/tone_map.h"
#include "harness/files.h"
#include "harness/measure.h"
#include "harness/report/cells.h"
#include "harness/report/data.h"
#include "harness/report/images.h"
#include "renderers/scene/error.h"
#include "renderers/scene/temporary_folder.h"

namespace occlab::history {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

/// The bytes of an image's PNG.
std::vector<std::uint8_t> png_bytes(const Image& image) {
  const TemporaryFolder folder;
  write_png(folder / "preview.png", image);
  const std::string text = read_text(folder / "preview.png");
  return {text.begin(), text.end()};
}

std::string text_at(const json& run, const char* object, const char* key) {
  const json found = object ? run.value(object, json::object()) : run;
  return found.is_object() ? found.value(key, "") : "";
}

}  // namespace

std::vector<Preview> make_previews(const fs::path& results, const json& run,
                                   std::vector<std::string>& problems) {
  if (report::is_of_several_benches(run)) {
    problems.push_back(fmt::format(
        "{}: no pictures are stored of a run of several scenes, views, resolutions or probes",
        results.string()));
    return {};
  }
  std::vector<report::Cell> cells = report::inspect_cells(results, run);
  const std::vector<report::Group> groups = report::group_cells(cells, run);
  std::vector<Preview> previews;
  std::set<std::string> methods;
  report::Frame frame;
  const auto make = [&](const report::Group& group) {
    report::Cell& cell = cells[group.cells.front()];
    const std::optional<Layers> layers = report::read_layers(cell);
    if (!layers) {
      problems.push_back(
          fmt::format("no preview of {}: cell {}: {}", group.method, cell.id, cell.problem));
      return;
    }
    if (!layers->find("radiance")) return;
    if (frame.width == 0) {
      frame = report::make_frame(group.reference ? &*layers : nullptr, &*layers);
    }
    const StageImage shown = stage_images(*layers).back();
    if (!shown.image.same_size(frame.mask)) return;
    const int factor = std::max(1, (frame.width + preview_width - 1) / preview_width);
    Preview preview{
        .scene = text_at(run, "scene", "name"),
        .view = text_at(run, nullptr, "view"),
        .method = group.method,
        .parameters = group.parameters,
        .stage = group.reference ? "" : shown.name,
        .hash = "",
        .png = png_bytes(shrink(tone_map(shown.image, frame.exposure, frame.mask), factor))};
    preview.hash =
        sha256_text({reinterpret_cast<const char*>(preview.png.data()), preview.png.size()});
    previews.push_back(std::move(preview));
  };
  for (const report::Group& group : groups) {
    if (methods.insert(group.method).second) make(group);
  }
  return previews;
}

}  // namespace occlab::history
