#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "harness/figures/figure_parts.h"
#include "harness/metrics/image_checks.h"

namespace occlab {
namespace {

std::string quantity_of(ErrorMap kind) {
  return kind == ErrorMap::signed_luminance
             ? "luminance error (Y \u2212 Y_ref) / mean Y_ref; 1 is the reference's mean "
               "luminance; "
               "blue: too dark, red: too bright"
             : "RMS error over R, G, B / mean Y_ref; 1 is the reference's mean luminance";
}

Image false_colour(const Image& error, const Image& mask, ErrorMap kind, double scale) {
  Image result = blank(error.width(), error.height(), figure_background);
  for (std::size_t i = 0; i < error.pixel_count(); ++i) {
    if (!(mask.values()[i] > 0.5f)) continue;
    const DisplayColour colour = error_colour(kind, error.values()[i], scale);
    std::ranges::copy(colour, result.values().subspan(3 * i, 3).begin());
  }
  return result;
}

std::string summary_text(const ErrorSummary& summary, ErrorMap kind) {
  std::string text =
      kind == ErrorMap::signed_luminance
          ? fmt::format("mean {}, mean magnitude {}", signed_number_text(summary.mean),
                        number_text(summary.mean_absolute))
          : fmt::format("mean {}", number_text(summary.mean));
  text += fmt::format("; beyond the scale {} %", number_text(100.0 * summary.beyond_scale, 2));
  if (summary.not_finite > 0) {
    text += fmt::format("; {} pixels not finite (magenta)", summary.not_finite);
  }
  return text;
}

/// The ends stand for everything beyond them.
std::string tick_text(std::span<const double> ticks, std::size_t i) {
  const bool is_signed = ticks.front() < 0.0;
  const std::string number = is_signed ? signed_number_text(ticks[i], 6) : number_text(ticks[i], 6);
  if (i + 1 == ticks.size()) return "\u2265 " + number;
  if (i == 0 && is_signed) return "\u2264 " + number;
  return number;
}

/// The bar in a thin frame, a tick and a number at each of its ticks, the quantity below.
Image legend(const std::string& quantity, ErrorMap kind, double scale, int width,
             const FigureSizes& sizes) {
  const int height = sizes.title * 5 / 4;
  const int line = std::max(1, sizes.border / 3);
  const Image bar = framed(colour_bar(kind, scale, width, height), line, ink);
  const auto ticks = error_scale_ticks(kind, scale);
  const int side = 4 * sizes.text;
  const int tick = sizes.text / 3;

  Image numbered = blank(bar.width() + 2 * side, bar.height() + tick + 3 * sizes.text / 2);
  paste(numbered, side, 0, bar);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const int x =
        side + line +
        static_cast<int>(std::lround(double(width) * double(i) / double(ticks.size() - 1)));
    fill(numbered, x - line / 2, bar.height(), line, tick, ink);
    const Image text = text_block(tick_text(ticks, i), {sizes.text}, 2 * side);
    paste(numbered, std::clamp(x - text.width() / 2, 0, numbered.width() - text.width()),
          bar.height() + tick, text);
  }
  return stack(
      {numbered, text_block(quantity, {sizes.text}, std::max(numbered.width(), 2 * width))},
      sizes.gap / 3, Placement::centre);
}

}  // namespace

Image decimated(const Image& image, int step) {
  Image result((image.width() + step - 1) / step, (image.height() + step - 1) / step,
               image.channels());
  for (int y = 0; y < result.height(); ++y) {
    for (int x = 0; x < result.width(); ++x) {
      const auto source = [step](int at, int size) {
        return std::min(size - 1, at * step + (at / 2) % step);
      };
      std::ranges::copy(image.pixel(source(x, image.width()), source(y, image.height())),
                        result.pixel(x, y).begin());
    }
  }
  return result;
}

ErrorSummary summarize_error(const Image& error, const Image& mask, double scale) {
  require_shape(error, "error", error, 1);
  require_shape(mask, "mask", error, 1);
  double sum = 0.0;
  double sum_absolute = 0.0;
  std::size_t finite = 0;
  std::size_t beyond = 0;
  ErrorSummary summary;
  for (const std::size_t index : foreground_pixels(mask)) {
    const double value = error.values()[index];
    if (!std::isfinite(value)) {
      ++summary.not_finite;
      continue;
    }
    ++finite;
    sum += value;
    sum_absolute += std::abs(value);
    if (std::abs(value) > scale) ++beyond;
  }
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const auto mean = [&](double total) { return finite > 0 ? total / double(finite) : nan; };
  summary.mean = mean(sum);
  summary.mean_absolute = mean(sum_absolute);
  summary.beyond_scale = mean(double(beyond));
  return summary;
}

Image error_figure(const ErrorFigure& figure) {
  require_some(figure.panels.size(), "panels");
  const Image& first = figure.panels.front().error;
  for (const ErrorPanel& panel : figure.panels) require_shape(panel.error, panel.label, first, 1);
  require_shape(figure.mask, "mask", first, 1);
  const int columns = std::min(figure.columns, int(figure.panels.size()));
  const int width = (first.width() + figure.step - 1) / figure.step;
  const FigureSizes sizes(columns * width);
  const Image shown_mask = decimated(figure.mask, figure.step);
  std::vector<Image> panels;
  for (const ErrorPanel& panel : figure.panels) {
    const Image map =
        false_colour(decimated(panel.error, figure.step), shown_mask, figure.kind, figure.scale);
    const ErrorSummary summary = summarize_error(panel.error, figure.mask, figure.scale);
    panels.push_back(stack({framed_panel(panel.label, panel.colour, map, sizes),
                            text_block(summary_text(summary, figure.kind), {sizes.text}, width)},
                           sizes.gap / 3));
  }
  const Image maps = grid(panels, columns, sizes.gap);
  const Image scale = legend(figure.quantity.empty() ? quantity_of(figure.kind) : figure.quantity,
                             figure.kind, figure.scale, maps.width() / 2, sizes);
  const Image centred_scale = centred(scale, maps.width(), scale.height());
  return page(figure.title, {maps, centred_scale}, figure.caption, sizes);
}

}  // namespace occlab
