#include "renderers/methods/hidden_facts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace occlab {
namespace {

/// A pixel's layers, walked from the viewer on.
struct Walk {
  bool open = false;
  bool paired = true;
  bool full = true;
};

Walk walk(std::span<const Image> sides, std::size_t pixel) {
  Walk result;
  int depth = 0;
  for (std::size_t layer = 0; layer < sides.size(); ++layer) {
    const float side = sides[layer].values()[pixel];
    if (side == 0.0f) {
      result.full = false;
      break;
    }
    const bool front = side < 1.5f;
    result.paired = result.paired && front == (layer % 2 == 0);
    depth += front ? 1 : -1;
    result.open = result.open || depth < 0;
  }
  result.open = result.open || (!result.full && depth != 0);
  return result;
}

struct CameraShares {
  double surface = 0.0;
  double back = 0.0;
};

CameraShares shares_of(const Image& sides) {
  const auto values = sides.values();
  const auto seen = std::ranges::count_if(values, [](float side) { return side > 0.0f; });
  const auto back = std::ranges::count_if(values, [](float side) { return side > 1.5f; });
  return {double(seen) / double(values.size()), seen == 0 ? 0.0 : double(back) / double(seen)};
}

}  // namespace

LayerSides count_sides(std::span<const Image> sides) {
  LayerSides counts;
  for (std::size_t pixel = 0; pixel < sides.front().pixel_count(); ++pixel) {
    const Walk found = walk(sides, pixel);
    counts.open_mesh_pixels += found.open ? 1 : 0;
    counts.overlapping_pixels += !found.open && !found.paired ? 1 : 0;
    counts.full_pixels += found.full ? 1 : 0;
  }
  return counts;
}

void add_hidden_facts(const Frame& frame, const HiddenSettings& settings, Metadata& facts) {
  const HiddenImages& hidden = frame.hidden_images(settings);
  if (settings.kind == HiddenKind::layers) {
    std::vector<Image> sides = {
        sides_of_first(frame.scene, frame.gpu_scene, frame.view, frame.programs)};
    for (const GBufferImages& layer : hidden.images) sides.push_back(layer.mask);
    const LayerSides counts = count_sides(sides);
    facts["open_mesh_pixels"] = std::to_string(counts.open_mesh_pixels);
    facts["overlapping_solid_pixels"] = std::to_string(counts.overlapping_pixels);
    facts["full_layer_pixels"] = std::to_string(counts.full_pixels);
    return;
  }
  std::vector<std::string> surface;
  std::vector<std::string> back;
  int blind = 0;
  for (const GBufferImages& camera : hidden.images) {
    const CameraShares shares = shares_of(camera.mask);
    surface.push_back(fmt::format("{:.3f}", shares.surface));
    back.push_back(fmt::format("{:.3f}", shares.back));
    blind += shares.surface == 0.0 ? 1 : 0;
  }
  facts["cameras_blind"] = std::to_string(blind);
  facts["camera_surface_share"] = fmt::format("{}", fmt::join(surface, " "));
  facts["camera_back_share"] = fmt::format("{}", fmt::join(back, " "));
}

}  // namespace occlab
