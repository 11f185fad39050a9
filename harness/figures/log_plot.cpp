#include "harness/figures/log_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "harness/figures/figure_parts.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr DisplayColour grid_colour = {0.88f, 0.88f, 0.88f};
constexpr double line_width = 2.0;
constexpr double marker_radius = 6.0;

/// A range of positive numbers on a stretch of pixels; `first` may be the larger pixel.
struct LogScale {
  double low = 1.0;
  double high = 10.0;
  double first = 0.0;
  double last = 1.0;

  double pixel(double value) const {
    return first + (last - first) * std::log(value / low) / std::log(high / low);
  }
};

struct Position {
  double x = 0.0;
  double y = 0.0;
};

/// Mixes a colour into a pixel; outside of the image is nothing.
void blend(Image& image, int x, int y, const DisplayColour& colour, double share) {
  if (x < 0 || y < 0 || x >= image.width() || y >= image.height() || share <= 0.0) return;
  const auto weight = float(std::min(1.0, share));
  for (int c = 0; c < 3; ++c) {
    float& value = image.at(x, y, c);
    value += weight * (colour[std::size_t(c)] - value);
  }
}

/// Every pixel within a box, by how far inside of a shape its centre is (negative: outside).
template <typename Inside>
void draw_shape(Image& image, Position low, Position high, const DisplayColour& colour,
                const Inside& inside) {
  for (int y = int(std::floor(low.y)) - 1; y <= int(std::ceil(high.y)) + 1; ++y) {
    for (int x = int(std::floor(low.x)) - 1; x <= int(std::ceil(high.x)) + 1; ++x) {
      blend(image, x, y, colour, inside(x + 0.5, y + 0.5) + 0.5);
    }
  }
}

void draw_line(Image& image, Position a, Position b, const DisplayColour& colour, double width) {
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double square = std::max(1e-12, dx * dx + dy * dy);
  const double reach = 0.5 * width;
  draw_shape(image, {std::min(a.x, b.x) - reach, std::min(a.y, b.y) - reach},
             {std::max(a.x, b.x) + reach, std::max(a.y, b.y) + reach}, colour,
             [&](double x, double y) {
               const double t = std::clamp(((x - a.x) * dx + (y - a.y) * dy) / square, 0.0, 1.0);
               return reach - std::hypot(x - a.x - t * dx, y - a.y - t * dy);
             });
}

/// Disc, square, diamond, triangle.
void draw_marker(Image& image, Position at, std::size_t shape, const DisplayColour& colour) {
  const double r = marker_radius;
  draw_shape(image, {at.x - r, at.y - r}, {at.x + r, at.y + r}, colour, [&](double x, double y) {
    const double dx = std::abs(x - at.x);
    const double dy = std::abs(y - at.y);
    switch (shape % 4) {
      case 0:
        return r - std::hypot(dx, dy);
      case 1:
        return 0.85 * r - std::max(dx, dy);
      case 2:
        return (1.25 * r - dx - dy) * std::sqrt(0.5);
      default:
        return std::min(0.6 * r - (y - at.y), (1.2 * r - 2.0 * dx + (y - at.y)) / std::sqrt(5.0));
    }
  });
}

/// 1, 2 and 5 times powers of ten; of a range beyond three decades the powers alone.
std::vector<double> ticks_within(double low, double high) {
  const bool wide = high / low > 1000.0;
  std::vector<double> ticks;
  for (int decade = int(std::floor(std::log10(low))); decade <= int(std::ceil(std::log10(high)));
       ++decade) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      if (wide && factor > 1.0) continue;
      const double tick = factor * std::pow(10.0, decade);
      if (tick >= low && tick <= high) ticks.push_back(tick);
    }
  }
  return ticks;
}

/// "1500", "57.6k", "2M".
std::string short_number(double value) {
  if (value >= 1e6) return fmt::format("{:.3g}M", value / 1e6);
  if (value >= 1e4) return fmt::format("{:.3g}k", value / 1e3);
  return fmt::format("{:.4g}", value);
}

void check(const LogPanel& panel) {
  const auto usable = [](double value) { return value > 0.0 && std::isfinite(value); };
  std::size_t points = 0;
  for (const LogSeries& series : panel.series) {
    for (const LogPoint& point : series.points) {
      ++points;
      if (!usable(point.x) || !usable(point.y) || !usable(point.lower) || !usable(point.upper)) {
        throw InputError(fmt::format(
            "plot '{}', {}: found ({}, {}) with an interval from {} to {}; accepted: positive, "
            "finite numbers",
            panel.title, series.label, point.x, point.y, point.lower, point.upper));
      }
    }
  }
  require_some(points, "points");
}

/// One panel under construction.
class Plot {
 public:
  Plot(const LogPanel& panel, int width, const FigureSizes& sizes)
      : panel_(panel), sizes_(sizes), image_(blank(width, width * 3 / 4)) {
    const double left = 4.5 * sizes.text;
    const double right = width - 2.0 * sizes.text;
    const double top = 0.5 * sizes.text;
    const double bottom = image_.height() - 3.5 * sizes.text;
    x_.first = left + 1.5 * marker_radius;
    x_.last = right - 1.5 * marker_radius;
    y_.first = bottom;
    y_.last = top;
    choose_ranges();
    draw_axes(left, right, top, bottom);
    for (std::size_t i = 0; i < panel.series.size(); ++i) draw_series(panel.series[i], i);
  }

  Image image() const { return image_; }

 private:
  void choose_ranges() {
    const LogPoint& first = [&]() -> const LogPoint& {
      for (const LogSeries& series : panel_.series) {
        if (!series.points.empty()) return series.points.front();
      }
      throw InputError("a plot without points");
    }();
    x_.low = x_.high = first.x;
    y_.low = y_.high = first.y;
    for (const LogSeries& series : panel_.series) {
      for (const LogPoint& point : series.points) {
        x_.low = std::min(x_.low, point.x);
        x_.high = std::max(x_.high, point.x);
        y_.low = std::min({y_.low, point.y, point.lower});
        y_.high = std::max({y_.high, point.y, point.upper});
      }
    }
    if (x_.low == x_.high) {
      x_.low /= 2.0;
      x_.high *= 2.0;
    }
    // At least a factor of 4, so that noise does not look like growth.
    const double room = std::max(1.15, std::sqrt(4.0 / (y_.high / y_.low)));
    y_.low /= room;
    y_.high *= room;
  }

  void draw_axes(double left, double right, double top, double bottom) {
    for (const double tick : ticks_within(y_.low, y_.high)) {
      const double y = y_.pixel(tick);
      draw_line(image_, {left, y}, {right, y}, grid_colour, 1.0);
      write(short_number(tick), left - 0.4 * sizes_.text, y, 1.0, 0.5);
    }
    double free_until = image_.width() + sizes_.text;
    const std::vector<std::pair<double, std::string>> ticks = x_ticks();
    for (auto tick = ticks.rbegin(); tick != ticks.rend(); ++tick) {
      const double x = x_.pixel(tick->first);
      draw_line(image_, {x, top}, {x, bottom}, grid_colour, 1.0);
      draw_line(image_, {x, bottom}, {x, bottom + 0.3 * sizes_.text}, ink, 1.5);
      const double half = 0.5 * text_width(tick->second, {sizes_.text});
      const double middle = std::min(x, image_.width() - half);
      if (middle + half > free_until) continue;  // rather one number less than two in one place
      write(tick->second, middle, bottom + 0.4 * sizes_.text, 0.5, 0.0);
      free_until = middle - half - 0.4 * sizes_.text;
    }
    draw_line(image_, {left, top}, {left, bottom}, ink, 1.5);
    draw_line(image_, {left, bottom}, {right, bottom}, ink, 1.5);
    write(panel_.x_label, 0.5 * (left + right), bottom + 1.9 * sizes_.text, 0.5, 0.0);
  }

  std::vector<std::pair<double, std::string>> x_ticks() const {
    if (!panel_.x_ticks.empty()) return panel_.x_ticks;
    std::vector<double> values;
    for (const LogSeries& series : panel_.series) {
      for (const LogPoint& point : series.points) values.push_back(point.x);
    }
    std::ranges::sort(values);
    values.erase(std::unique(values.begin(), values.end()), values.end());
    std::vector<std::pair<double, std::string>> ticks;
    for (const double value : values) ticks.emplace_back(value, short_number(value));
    return ticks;
  }

  void draw_series(const LogSeries& series, std::size_t shape) {
    std::vector<LogPoint> points = series.points;
    std::ranges::sort(points, {}, &LogPoint::x);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Position at = {x_.pixel(points[i].x), y_.pixel(points[i].y)};
      if (i > 0) {
        draw_line(image_, {x_.pixel(points[i - 1].x), y_.pixel(points[i - 1].y)}, at, series.colour,
                  line_width);
      }
      draw_line(image_, {at.x, y_.pixel(points[i].lower)}, {at.x, y_.pixel(points[i].upper)},
                series.colour, line_width);
      draw_marker(image_, at, shape, series.colour);
    }
  }

  /// The text with the point of itself that `anchor_x` and `anchor_y` (0 to 1) name at (x, y),
  /// moved into the image where it would leave it.
  void write(const std::string& text, double x, double y, double anchor_x, double anchor_y) {
    const Image block = text_block(text, {sizes_.text}, image_.width());
    const int left = int(std::lround(x - anchor_x * block.width()));
    const int top = int(std::lround(y - anchor_y * block.height()));
    paste(image_, std::clamp(left, 0, image_.width() - block.width()),
          std::clamp(top, 0, image_.height() - block.height()), block);
  }

  const LogPanel& panel_;
  const FigureSizes& sizes_;
  Image image_;
  LogScale x_;
  LogScale y_;
};

Image legend(const std::vector<LogSeries>& series, const FigureSizes& sizes, int width) {
  std::vector<Image> entries;
  for (std::size_t i = 0; i < series.size(); ++i) {
    Image sample = blank(3 * sizes.text, sizes.text * 5 / 4);
    const double y = 0.5 * sample.height();
    draw_line(sample, {4.0, y}, {sample.width() - 4.0, y}, series[i].colour, line_width);
    draw_marker(sample, {0.5 * sample.width(), y}, i, series[i].colour);
    entries.push_back(beside({sample, text_block(series[i].label, {sizes.text}, width)},
                             sizes.gap / 2, Placement::centre));
  }
  return beside(entries, 2 * sizes.gap, Placement::centre);
}

}  // namespace

Image log_plot_figure(const LogPlotFigure& figure) {
  require_some(figure.panels.size(), "panels");
  const FigureSizes sizes(figure.width);
  const int width = (figure.width - 4 * sizes.gap) / int(figure.panels.size()) - sizes.gap;
  std::vector<Image> panels;
  for (const LogPanel& panel : figure.panels) {
    check(panel);
    panels.push_back(stack({text_block(panel.title, {sizes.text, Weight::bold}, width),
                            Plot(panel, width, sizes).image()},
                           sizes.gap / 2));
  }
  return page(
      figure.title,
      {legend(figure.panels.front().series, sizes, figure.width), beside(panels, sizes.gap)},
      figure.caption, sizes);
}

}  // namespace occlab
