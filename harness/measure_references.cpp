#include "harness/measure_references.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "harness/figures/figures.h"
#include "harness/metrics/brightness.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

Image optional_layer(const Layers& layers, const char* name) {
  const Image* image = layers.find(name);
  return image ? *image : Image();
}

std::vector<ReferenceImages> reference_images(const Layers& layers, const std::string& view,
                                              const std::vector<Region>& regions) {
  std::vector<ReferenceImages> images;
  images.push_back({view, std::nullopt, false, layers.at("radiance"), layers.at("mask"),
                    optional_layer(layers, "radiance_variance"),
                    optional_layer(layers, "ambient_occlusion")});
  for (const Region& region : regions) {
    const auto part = [&](const Image& image) {
      return image.empty() ? Image() : crop(image, region.rectangle);
    };
    const ReferenceImages& whole = images.front();
    if (region.point && !(whole.mask.at(region.rectangle.x, region.rectangle.y) > 0.5f)) {
      throw InputError(fmt::format("view '{}': point '{}' shows no surface", view, region.name));
    }
    images.push_back({view_of_region(view, region.name), region.rectangle, region.point,
                      part(whole.radiance), part(whole.mask), part(whole.variance),
                      part(whole.occlusion)});
  }
  return images;
}

}  // namespace

std::vector<MetricValue> ReferenceImages::measure(const Image& test) const {
  const Image part = rectangle ? crop(test, *rectangle) : Image();
  const Image& image = rectangle ? part : test;
  std::vector<MetricValue> values;
  if (!point) {
    values = occlab::measure({.reference = radiance,
                              .test = image,
                              .mask = mask,
                              .reference_occlusion = occlusion.empty() ? nullptr : &occlusion,
                              .reference_variance = variance.empty() ? nullptr : &variance});
  }
  std::ranges::move(measure_brightness(image, mask), std::back_inserter(values));
  return values;
}

std::vector<Reference> read_references(const std::vector<MeasuredCell>& cells,
                                       const std::vector<Region>& regions, const std::string& view,
                                       const ReadLayers& read,
                                       const std::function<void(std::size_t)>& progress) {
  std::vector<Reference> references;
  for (std::size_t i = 0; i < cells.size() && cells[i].planned.role == Role::reference; ++i) {
    progress(i);
    references.push_back({cells[i].id, reference_images(read(cells[i]), view, regions)});
  }
  return references;
}

}  // namespace occlab
