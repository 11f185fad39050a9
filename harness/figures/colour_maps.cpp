#include "harness/figures/colour_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr DisplayColour from_hex(std::uint32_t rgb) {
  return {static_cast<float>(rgb >> 16 & 0xff) / 255.0f,
          static_cast<float>(rgb >> 8 & 0xff) / 255.0f, static_cast<float>(rgb & 0xff) / 255.0f};
}

constexpr std::array<DisplayColour, 8> frame_palette = {
    from_hex(0xc8201e), from_hex(0x1a8a2a), from_hex(0x1f55c8), from_hex(0x8430aa),
    from_hex(0x666666), from_hex(0xb85c00), from_hex(0x007f8c), from_hex(0x7a4a22)};

// ColorBrewer RdBu with 11 classes, from blue to red (Brewer, colorbrewer2.org, Apache 2.0;
// Harrower and Brewer 2003, "ColorBrewer.org: an online tool for selecting colour schemes for
// maps").
constexpr std::array<DisplayColour, 11> diverging = {
    from_hex(0x053061), from_hex(0x2166ac), from_hex(0x4393c3), from_hex(0x92c5de),
    from_hex(0xd1e5f0), from_hex(0xf7f7f7), from_hex(0xfddbc7), from_hex(0xf4a582),
    from_hex(0xd6604d), from_hex(0xb2182b), from_hex(0x67001f)};

// viridis: every 17th of its 256 colours (van der Walt and Smith 2015, "A better default colormap
// for Matplotlib", SciPy; CC0).
constexpr std::array<DisplayColour, 16> sequential = {
    from_hex(0x440154), from_hex(0x481a6c), from_hex(0x472f7d), from_hex(0x414487),
    from_hex(0x39568c), from_hex(0x31688e), from_hex(0x2a788e), from_hex(0x23888e),
    from_hex(0x1f988b), from_hex(0x22a884), from_hex(0x35b779), from_hex(0x54c568),
    from_hex(0x7ad151), from_hex(0xa5db36), from_hex(0xd2e21b), from_hex(0xfde725)};

template <std::size_t count>
DisplayColour between(const std::array<DisplayColour, count>& table, double position) {
  const double along = position * double(count - 1);
  const std::size_t left = std::min(static_cast<std::size_t>(along), count - 2);
  const auto weight = static_cast<float>(along - double(left));
  DisplayColour colour;
  for (std::size_t c = 0; c < 3; ++c) {
    colour[c] = std::lerp(table[left][c], table[left + 1][c], weight);
  }
  return colour;
}

void require_scale(double scale) {
  if (!(scale > 0.0) || !std::isfinite(scale)) {
    throw InputError(fmt::format("scale {} of an error map: accepted: positive numbers", scale));
  }
}

}  // namespace

DisplayColour frame_colour(std::size_t index) {
  return frame_palette[index % frame_palette.size()];
}

std::map<std::string, DisplayColour> frame_colours(
    std::span<const std::vector<std::string>> names_of_figures) {
  std::map<std::string, DisplayColour> colours;
  for (const std::vector<std::string>& names : names_of_figures) {
    for (const std::string& name : names) colours.try_emplace(name, frame_colour(colours.size()));
  }
  return colours;
}

DisplayColour error_colour(ErrorMap kind, double error, double scale) {
  require_scale(scale);
  if (!std::isfinite(error)) return not_finite_colour;
  const double start = error_scale_start(kind, scale);
  const double position = std::clamp((error - start) / (scale - start), 0.0, 1.0);
  return kind == ErrorMap::signed_luminance ? between(diverging, position)
                                            : between(sequential, position);
}

double error_scale_start(ErrorMap kind, double scale) {
  require_scale(scale);
  return kind == ErrorMap::signed_luminance ? -scale : 0.0;
}

std::array<double, 5> error_scale_ticks(ErrorMap kind, double scale) {
  const double start = error_scale_start(kind, scale);
  std::array<double, 5> ticks;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    ticks[i] = start + (scale - start) * double(i) / double(ticks.size() - 1);
  }
  return ticks;
}

Image colour_bar(ErrorMap kind, double scale, int width, int height) {
  const double start = error_scale_start(kind, scale);
  Image bar(width, height, 3);
  for (int x = 0; x < width; ++x) {
    const double error = start + (scale - start) * (x + 0.5) / width;
    const DisplayColour colour = error_colour(kind, error, scale);
    for (int y = 0; y < height; ++y) std::ranges::copy(colour, bar.pixel(x, y).begin());
  }
  return bar;
}

}  // namespace occlab
