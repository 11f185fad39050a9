#include "harness/measure_references.h"

#include "harness/figures/figures.h"

namespace occlab {
namespace {

Image optional_layer(const Layers& layers, const char* name) {
  const Image* image = layers.find(name);
  return image ? *image : Image();
}

std::vector<ReferenceImages> reference_images(const Layers& layers, const std::string& view,
                                              const std::vector<Region>& regions) {
  std::vector<ReferenceImages> images;
  images.push_back({view, std::nullopt, layers.at("radiance"), layers.at("mask"),
                    optional_layer(layers, "radiance_variance"),
                    optional_layer(layers, "ambient_occlusion")});
  for (const Region& region : regions) {
    const auto part = [&](const Image& image) {
      return image.empty() ? Image() : crop(image, region.rectangle);
    };
    const ReferenceImages& whole = images.front();
    images.push_back({view_of_region(view, region.name), region.rectangle, part(whole.radiance),
                      part(whole.mask), part(whole.variance), part(whole.occlusion)});
  }
  return images;
}

}  // namespace

std::vector<MetricValue> ReferenceImages::measure(const Image& test) const {
  return occlab::measure({.reference = radiance,
                          .test = rectangle ? crop(test, *rectangle) : test,
                          .mask = mask,
                          .reference_occlusion = occlusion.empty() ? nullptr : &occlusion,
                          .reference_variance = variance.empty() ? nullptr : &variance});
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
