#include "harness/experiment_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "harness/figures/figures.h"
#include "harness/files.h"
#include "renderers/methods/method.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

/// The images of an experiment's cells as its figures want them.
class FigureSource {
 public:
  FigureSource(const Experiment& experiment, const std::vector<MeasuredCell>& cells,
               const ReadLayers& read)
      : cells_(cells), read_(read) {
    for (const MeasuredCell& cell : cells) planned_.push_back(cell.planned);
    const Layers reference = read(cells.front());
    reference_ = reference.at("radiance");
    mask_ = reference.at("mask");
    exposure_ = shared_exposure(reference_, mask_);
    std::vector<std::vector<std::string>> names;
    for (const FigureSettings& figure : experiment.figures) names.push_back(figure.methods);
    colours_ = frame_colours(names);
  }

  const Image& reference() const { return reference_; }
  const Image& mask() const { return mask_; }
  double exposure() const { return exposure_; }
  DisplayColour colour(const std::string& method) const { return colours_.at(method); }

  /// Linear radiance of the first seed of the selected cells.
  Image radiance(const std::string& method, const NamedValues& select,
                 const std::string& stage) const {
    const int group = select_group(planned_, method, select);
    const auto cell = std::ranges::find(planned_, group, &PlannedCell::group);
    const Layers layers = read_(cells_[std::size_t(cell - planned_.begin())]);
    const Image* unfiltered = layers.find("radiance_unfiltered");
    return stage == "unfiltered" && unfiltered ? *unfiltered : layers.at("radiance");
  }

  Image displayed(const std::string& method, const NamedValues& select,
                  const std::string& stage) const {
    return tone_map(radiance(method, select, stage), exposure_, mask_);
  }

 private:
  const std::vector<MeasuredCell>& cells_;
  const ReadLayers& read_;
  std::vector<PlannedCell> planned_;
  Image reference_;
  Image mask_;
  double exposure_ = 1.0;
  std::map<std::string, DisplayColour> colours_;
};

std::string describe(const NamedValues& select) {
  std::string text;
  for (const auto& [name, value] : select) {
    text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", name, to_string(value));
  }
  return text;
}

std::string display_caption(const FigureSettings& figure, const FigureSource& source) {
  return fmt::format(
      "{} images. All panels share one exposure, {:.4g}, at which the reference's 99th-percentile "
      "luminance is white.{}",
      figure.stage == "filtered" ? "Filtered" : "Unfiltered", source.exposure(),
      figure.select.empty() ? "" : " Screen-space methods: " + describe(figure.select) + ".");
}

Image draw_comparison(const FigureSettings& settings, const FigureSource& source) {
  ComparisonFigure figure{settings.title, {}, display_caption(settings, source)};
  for (const std::string& method : settings.methods) {
    figure.panels.push_back({find_method(method).title, source.colour(method),
                             source.displayed(method, settings.select, settings.stage)});
  }
  return comparison_figure(figure);
}

Image draw_closeups(const FigureSettings& settings, const FigureSource& source) {
  CloseupFigure figure;
  figure.title = settings.title;
  figure.overview = tone_map(source.reference(), source.exposure(), source.mask());
  figure.caption = display_caption(settings, source);
  for (const std::string& method : settings.methods) {
    figure.columns.push_back({find_method(method).title, source.colour(method)});
  }
  for (const CloseupRow& row : settings.rows) {
    CloseupFigureRow closeups{row.label, describe(row.select), row.rectangle, {}};
    for (const std::string& method : settings.methods) {
      closeups.images.push_back(source.displayed(method, row.select, settings.stage));
    }
    figure.rows.push_back(std::move(closeups));
  }
  return closeup_figure(figure);
}

Image draw_errors(const FigureSettings& settings, const FigureSource& source) {
  ErrorFigure figure;
  figure.title = settings.title;
  figure.kind = ErrorMap::signed_luminance;
  figure.scale = settings.scale;
  figure.mask = source.mask();
  figure.caption = fmt::format(
      "{} images minus the reference, in units of the reference's mean luminance; one fixed scale. "
      "{}",
      settings.stage == "filtered" ? "Filtered" : "Unfiltered", describe(settings.select));
  for (const std::string& method : settings.methods) {
    const Image radiance = source.radiance(method, settings.select, settings.stage);
    figure.panels.push_back(
        {find_method(method).title, source.colour(method),
         error_map({.reference = source.reference(), .test = radiance, .mask = source.mask()},
                   figure.kind)});
  }
  return error_figure(figure);
}

Image draw(const FigureSettings& settings, const FigureSource& source) {
  switch (settings.kind) {
    case FigureKind::comparison:
      return draw_comparison(settings, source);
    case FigureKind::closeups:
      return draw_closeups(settings, source);
    case FigureKind::error_map:
      return draw_errors(settings, source);
  }
  return {};
}

}  // namespace

void write_figures(const Experiment& experiment, const std::vector<MeasuredCell>& cells,
                   const ReadLayers& read, const std::filesystem::path& folder) {
  if (experiment.figures.empty()) return;
  if (cells.empty() || cells.front().planned.role != Role::reference) {
    throw InputError(
        fmt::format("{}: key 'figure': figures need a [reference]", experiment.file.string()));
  }
  create_folder(folder);
  const FigureSource source(experiment, cells, read);
  for (const FigureSettings& settings : experiment.figures) {
    write_png(folder / (settings.name + ".png"), draw(settings, source));
  }
}

}  // namespace occlab
