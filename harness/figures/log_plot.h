#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "harness/figures/colour_maps.h"
#include "renderers/scene/image.h"

namespace occlab {

// Plots on logarithmic axes, as a figure for write_png (figures.h).

struct LogPoint {
  double x = 0.0;      ///< positive
  double y = 0.0;      ///< positive
  double lower = 0.0;  ///< of y, positive
  double upper = 0.0;
};

struct LogSeries {
  std::string label;
  DisplayColour colour{};
  std::vector<LogPoint> points;  ///< joined by lines in the order of x
};

struct LogPanel {
  std::string title;    ///< what y is, with its unit
  std::string x_label;  ///< with its unit
  std::vector<LogSeries> series;
  /// What stands at places of the x axis; empty: at every point's x, its number.
  std::vector<std::pair<double, std::string>> x_ticks = {};
};

struct LogPlotFigure {
  std::string title;
  std::vector<LogPanel> panels;  ///< beside one another
  std::string caption;
  int width = 1280;  ///< pixels, about, of the whole figure
};

/// Each series has a marker of its own beside its colour, and the bar of its interval where that is
/// longer than the marker. Throws InputError for a figure without panels, a panel without points
/// and numbers that are not positive and finite; DeviceError without the font.
Image log_plot_figure(const LogPlotFigure& figure);

}  // namespace occlab
