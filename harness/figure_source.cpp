#include "harness/figure_source.h"

#include <algorithm>

#include "harness/figures/tone_map.h"

namespace occlab {

FigureSource::FigureSource(const FigureBench& bench,
                           const std::map<std::string, DisplayColour>& colours)
    : bench_(bench), colours_(colours) {
  for (const MeasuredCell& cell : bench.cells) {
    planned_.push_back(cell.planned);
    if (cell.planned.role != Role::reference) continue;
    const Layers reference = bench.read(cell);
    references_.push_back(reference.at("radiance"));
    mask_ = reference.at("mask");
  }
  exposure_ = shared_exposure(references_.front(), mask_);
}

const Image& FigureSource::reference_of(const std::string& method,
                                        const NamedValues& select) const {
  return references_[reference_place(planned_, cell(method, select).planned)];
}

const MeasuredCell& FigureSource::cell(const std::string& method, const NamedValues& select) const {
  const int group = select_group(planned_, method, select);
  const auto found = std::ranges::find(planned_, group, &PlannedCell::group);
  return bench_.cells[std::size_t(found - planned_.begin())];
}

Image FigureSource::radiance(const std::string& method, const NamedValues& select,
                             const std::string& stage) const {
  const Layers layers = bench_.read(cell(method, select));
  const Image* unfiltered = layers.find("radiance_unfiltered");
  return stage == "unfiltered" && unfiltered ? *unfiltered : layers.at("radiance");
}

Image FigureSource::displayed(const std::string& method, const NamedValues& select,
                              const std::string& stage) const {
  return tone_map(radiance(method, select, stage), exposure_, mask_);
}

FigureSources::FigureSources(const Experiment& experiment, const std::vector<FigureBench>& benches)
    : benches_(benches), sources_(benches.size()) {
  std::vector<std::vector<std::string>> names;
  for (const FigureSettings& figure : experiment.figures) names.push_back(figure.methods);
  colours_ = frame_colours(names);
}

const FigureSource& FigureSources::at(std::size_t bench) {
  if (!sources_[bench]) sources_[bench] = std::make_unique<FigureSource>(benches_[bench], colours_);
  return *sources_[bench];
}

}  // namespace occlab
