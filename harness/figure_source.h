#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "harness/experiment_figures.h"
#include "harness/figures/colour_maps.h"
#include "renderers/scene/image.h"

namespace occlab {

/// The images of one bench's cells as figures want them.
class FigureSource {
 public:
  /// Reads the references. `bench` and `colours` outlive this.
  FigureSource(const FigureBench& bench, const std::map<std::string, DisplayColour>& colours);

  /// The first, whose exposure all share.
  const Image& reference() const { return references_.front(); }
  /// That which the selected cells are compared with.
  const Image& reference_of(const std::string& method, const NamedValues& select) const;
  const Image& mask() const { return mask_; }
  double exposure() const { return exposure_; }
  DisplayColour colour(const std::string& method) const { return colours_.at(method); }

  /// The first seed of the selected cells.
  const MeasuredCell& cell(const std::string& method, const NamedValues& select) const;
  Layers layers(const MeasuredCell& cell) const { return bench_.read(cell); }
  const StoredBudget& budget(const MeasuredCell& cell) const {
    return bench_.read_budget(cell.planned);
  }

  /// Linear radiance of the first seed of the selected cells.
  Image radiance(const std::string& method, const NamedValues& select,
                 const std::string& stage) const;
  /// The same at this source's exposure.
  Image displayed(const std::string& method, const NamedValues& select,
                  const std::string& stage) const;

 private:
  const FigureBench& bench_;
  const std::map<std::string, DisplayColour>& colours_;
  std::vector<PlannedCell> planned_;
  std::vector<Image> references_;
  Image mask_;
  double exposure_ = 1.0;
};

/// The sources of an experiment's benches, made when they are first asked for.
class FigureSources {
 public:
  /// Both outlive this.
  FigureSources(const Experiment& experiment, const std::vector<FigureBench>& benches);

  const FigureSource& at(std::size_t bench);
  DisplayColour colour(const std::string& method) const { return colours_.at(method); }

 private:
  const std::vector<FigureBench>& benches_;
  std::map<std::string, DisplayColour> colours_;
  std::vector<std::unique_ptr<FigureSource>> sources_;
};

}  // namespace occlab
