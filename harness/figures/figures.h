#pragma once

#include <optional>
#include <string>
#include <vector>

#include "harness/config.h"
#include "harness/figures/colour_maps.h"
#include "harness/figures/tone_map.h"
#include "harness/metrics/metrics.h"
#include "renderers/scene/image.h"

namespace occlab {

// Figures as in a paper: from images to one display-referred sRGB image with three channels in
// [0, 1], for write_png. They know no method and read no file but the font.
//
// All throw InputError for a figure without panels, images of different sizes or other numbers of
// channels than stated, values of a shown image outside [0, 1], and rectangles that are empty or
// leave the frame; DeviceError without the font (DejaVu Sans, Debian's fonts-dejavu-core). Texts
// are UTF-8.

/// A method's image in a figure.
struct Panel {
  std::string label;
  DisplayColour colour = frame_colour(0);  ///< of its frame and label
  Image image;                             ///< three channels, display-referred: see tone_map
};

struct ComparisonFigure {
  std::string title;          ///< one line or more; may be empty
  std::vector<Panel> panels;  ///< all of one size
  std::string caption;        ///< wrapped to the figure's width; '\n' starts a paragraph
  int columns = 2;
};

/// Panels pixel by pixel in columns (Fig. 7 of the S3HO paper), each in its colour.
Image comparison_figure(const ComparisonFigure& figure);

struct CloseupFigureRow {
  std::string label;
  std::string note;           ///< what else the row's cells share, such as "N = 32, S = 2"
  Rectangle rectangle;        ///< pixels, inside the frame
  std::vector<Image> images;  ///< a full frame for each column; display-referred, three channels
};

struct CloseupColumn {
  std::string label;
  DisplayColour colour = frame_colour(0);
};

struct CloseupFigure {
  std::string title;
  Image overview;  ///< the frame that the rectangles are drawn into and numbered; as `images`
  std::vector<CloseupColumn> columns;
  std::vector<CloseupFigureRow> rows;
  std::string caption;
  int magnification = 3;  ///< screen pixels a frame pixel in the largest rectangle, 1 to 16
};

/// Rows of closeups, a column a method (Fig. 8), below the overview. All cells have one size, that
/// of the largest rectangle's closeup; a smaller rectangle is magnified as many whole times as fit,
/// and each row says how many. Every frame pixel stays a square of one colour.
Image closeup_figure(const CloseupFigure& figure);

/// A column or a row of a grid.
struct GridHeading {
  std::string label;
  DisplayColour colour = {};           ///< of its label
  std::string note;                    ///< what else its panels share
  std::optional<Rectangle> rectangle;  ///< a row of closeups: pixels, inside the frame
};

struct GridFigure {
  std::string title;
  std::vector<GridHeading> columns;
  std::vector<GridHeading> rows;
  std::vector<Image> images;  ///< row by row: full frames of one size, display-referred
  std::string caption;
};

/// Whole frames in columns and rows, and under them rows of closeups, whose numbered rectangles the
/// whole frames show (Figs. 3, 4, 6 and 14 of the SSDO paper). Frames are made smaller by a whole
/// factor where the page would be wider than 2600 pixels; closeups are as wide as they fit, every
/// frame pixel a square of one colour.
Image grid_figure(const GridFigure& figure);

/// The image with numbered outlines, 1, 2, ... in the order given; outlines lie outside of the
/// rectangles where the frame leaves room, so that what is shown enlarged stays visible.
Image draw_rectangles(const Image& image, const std::vector<Rectangle>& rectangles);

/// The rectangle of an image, every pixel repeated `magnification` times each way.
Image crop(const Image& image, const Rectangle& rectangle, int magnification = 1);

/// A place of an image that is marked and named.
struct MarkedPoint {
  std::string label;
  int x = 0;  ///< pixels, inside the image
  int y = 0;
};

/// The image with a ring around every point and its label beside it.
Image draw_points(const Image& image, const std::vector<MarkedPoint>& points);

/// A square picture, such as a lobe, with what it is above and what is to be said of it below.
struct SpherePanel {
  std::string label;
  Image image;       ///< display-referred, three channels
  std::string note;  ///< wrapped to the image's width
};

struct LobeFigure {
  std::string title;
  std::vector<Panel> panels;         ///< one, or two with the spheres between them
  std::vector<SpherePanel> spheres;  ///< in a row
  std::string caption;
};

/// A picture, the spheres that belong to points of it, and under them another picture of the same
/// points, if there is one (Figs. 3 and 5 of the S3HO paper).
Image lobe_figure(const LobeFigure& figure);

struct ErrorPanel {
  std::string label;
  DisplayColour colour = frame_colour(0);
  Image error;  ///< one channel, from error_map() of the figure's kind
};

struct ErrorFigure {
  std::string title;
  ErrorMap kind = ErrorMap::signed_luminance;
  double scale = 0.0;  ///< the error at the end of the colour scale; positive
  Image mask;          ///< one channel; the statistics are over where it exceeds 0.5
  std::vector<ErrorPanel> panels;
  std::string caption;
  int columns = 2;
  int step = 1;          ///< every so-many-th pixel each way is shown; statistics are over all
  std::string quantity;  ///< of the colour bar; empty: that of `kind`
};

/// What stands under a panel of an error figure. Means are over the finite errors of the mask; they
/// are NaN if there is none.
struct ErrorSummary {
  double mean = 0.0;
  double mean_absolute = 0.0;
  double beyond_scale = 0.0;   ///< fraction of finite errors that the colour scale cuts off
  std::size_t not_finite = 0;  ///< pixels
};
ErrorSummary summarize_error(const Image& error, const Image& mask, double scale);

/// One pixel of every `step` x `step`, at places that take turns: all sets of a 4x4 interleaved
/// pattern are shown alike.
Image decimated(const Image& image, int step);

/// Error maps in columns on one fixed scale, printed as a colour bar with its numbers and unit;
/// under each its mean error, and what the scale cuts off.
Image error_figure(const ErrorFigure& figure);

}  // namespace occlab
