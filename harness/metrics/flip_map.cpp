// FLIP of two displayed images, after Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom and
// Fairchild 2020, "FLIP: A Difference Evaluator for Alternating Images"; names and constants are
// the paper's.
#include "harness/metrics/flip_map.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "harness/metrics/fast_math.h"
#include "harness/metrics/flip_filters.h"
#include "harness/metrics/parallel.h"

namespace occlab {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

// X/X_n, Y/Y_n and Z/Z_n of linear RGB.
constexpr Matrix relative_xyz_from_rgb() {
  Matrix matrix = xyz_from_rgb;
  for (std::size_t row = 0; row < 3; ++row) {
    for (double& weight : matrix[row]) weight /= white_xyz[row];
  }
  return matrix;
}

constexpr Matrix opponent_from_rgb() {
  const Matrix xyz = relative_xyz_from_rgb();
  Matrix matrix{};
  for (std::size_t c = 0; c < 3; ++c) {
    matrix[0][c] = xyz[1][c];
    matrix[1][c] = xyz[0][c] - xyz[1][c];
    matrix[2][c] = xyz[1][c] - xyz[2][c];
  }
  return matrix;
}

constexpr Matrix inverse(const Matrix& m) {
  const auto minor = [&](std::size_t i, std::size_t j) {
    const std::size_t a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
    return m[a][c] * m[b][d] - m[a][d] * m[b][c];
  };
  const double determinant = m[0][0] * minor(0, 0) + m[0][1] * minor(0, 1) + m[0][2] * minor(0, 2);
  Matrix result{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) result[i][j] = minor(j, i) / determinant;
  }
  return result;
}

constexpr Matrix to_xyz = relative_xyz_from_rgb();
constexpr Matrix to_opponent = opponent_from_rgb();
constexpr Matrix to_rgb = inverse(to_opponent);

// Every tone curve exceeds 1 from here on, and squares of larger values might overflow.
constexpr float far_beyond_white = 1e4f;

inline float apply(const std::array<double, 3>& row, float a, float b, float c) {
  return static_cast<float>(row[0]) * a + static_cast<float>(row[1]) * b +
         static_cast<float>(row[2]) * c;
}

// The image is filtered in tiles that stay in a core's cache; what a tile holds beyond the image's
// right and bottom border is computed and left.
constexpr int tile_width = 64;
constexpr int tile_height = 64;
constexpr int padded_width = tile_width + 2 * flip_reach;
constexpr int padded_height = tile_height + 2 * flip_reach;

using TileRow = std::array<float, tile_width>;
using PaddedRow = std::array<float, padded_width>;
/// What one filter gave across, for the tile's rows and those that the filter down reaches.
using AcrossPlane = std::array<TileRow, padded_height>;

// Columns that are added up at a time. The compiler's own vectors, because from plain arrays GCC 12
// gathers the taps behind the centre float by float.
using Lanes [[gnu::vector_size(32)]] = float;
constexpr int lanes = sizeof(Lanes) / sizeof(float);
static_assert(tile_width % (2 * lanes) == 0);

inline Lanes load(const float* at) {
  Lanes values;
  std::memcpy(&values, at, sizeof(values));
  return values;
}

inline void store(float* at, Lanes values) { std::memcpy(at, &values, sizeof(values)); }

enum class Kernel { smooth, edge, point };

// What the taps at +k and -k add; `ahead` and `behind` are the values there.
template <Kernel kind>
Lanes paired(Lanes ahead, Lanes behind, Lanes centre) {
  if constexpr (kind == Kernel::smooth) return ahead + behind;
  if constexpr (kind == Kernel::edge) return ahead - behind;
  // The point detector's taps add up to 0, so that the centre's is minus the others' sum. In this
  // form an even surface gives exactly 0: of the feature difference FLIP takes the root, which
  // would make 1e-4 of a rounding error.
  if constexpr (kind == Kernel::point) return (ahead - centre) + (behind - centre);
}

// A row of the kernel's sums around `at`, whose neighbours in the kernel's direction are `stride`
// floats apart.
template <Kernel kind, int stride>
void convolve(TileRow& target, const FlipTaps& kernel, const float* at) {
  constexpr std::ptrdiff_t step = 2 * std::ptrdiff_t(lanes);
  for (std::ptrdiff_t x = 0; x < tile_width; x += step, at += step) {
    const Lanes low_centre = load(at);
    const Lanes high_centre = load(at + lanes);
    Lanes low{}, high{};
    if (kind == Kernel::smooth) {
      low = kernel.taps[0] * low_centre;
      high = kernel.taps[0] * high_centre;
    }
    for (int k = 1; k <= kernel.radius; ++k) {
      const float tap = kernel.taps[std::size_t(k)];
      const float* ahead = at + std::ptrdiff_t(k) * stride;
      const float* behind = at - std::ptrdiff_t(k) * stride;
      low += tap * paired<kind>(load(ahead), load(behind), low_centre);
      high += tap * paired<kind>(load(ahead + lanes), load(behind + lanes), high_centre);
    }
    store(target.data() + x, low);
    store(target.data() + x + lanes, high);
  }
}

template <int stride>
void smooth_row(TileRow& target, const FlipTaps& kernel, const float* at) {
  convolve<Kernel::smooth, stride>(target, kernel, at);
}

template <int stride>
void edge_row(TileRow& target, const float* at) {
  convolve<Kernel::edge, stride>(target, flip_filters().edge, at);
}

template <int stride>
void point_row(TileRow& target, const float* at) {
  convolve<Kernel::point, stride>(target, flip_filters().point, at);
}

/// One row of a tile as the observer sees it.
struct SeenRow {
  TileRow l, a, b;  ///< CIE L*a*b* after the Hunt effect
  TileRow edge, point;
};

/// One image's tile, filtered across.
struct Tile {
  AcrossPlane achromatic, red_green;
  std::array<AcrossPlane, 2> blue_yellow;
  AcrossPlane gaussian, edge, point;
};

// A row of the plane from `left` on, clamped to the image.
void copy_padded(PaddedRow& target, const Plane& plane, int width, int row, int left) {
  const float* source = plane.data() + std::size_t(row) * std::size_t(width);
  const int first = std::clamp(-left, 0, padded_width);
  const int last = std::clamp(width - left, first, padded_width);
  std::fill(target.begin(), target.begin() + first, source[0]);
  std::copy(source + left + first, source + left + last, target.begin() + first);
  std::fill(target.begin() + last, target.end(), source[width - 1]);
}

void filter_across(Tile& tile, const FlipImage& image, int left, int top) {
  const FlipFilters& filters = flip_filters();
  PaddedRow y, cx, cz;
  for (int i = 0; i < padded_height; ++i) {
    const int row = std::clamp(top - flip_reach + i, 0, image.height - 1);
    copy_padded(y, image.opponent[0], image.width, row, left - flip_reach);
    copy_padded(cx, image.opponent[1], image.width, row, left - flip_reach);
    copy_padded(cz, image.opponent[2], image.width, row, left - flip_reach);
    const auto at = std::size_t(i);
    smooth_row<1>(tile.achromatic[at], filters.achromatic, y.data() + flip_reach);
    smooth_row<1>(tile.red_green[at], filters.red_green, cx.data() + flip_reach);
    smooth_row<1>(tile.blue_yellow[0][at], filters.blue_yellow[0], cz.data() + flip_reach);
    smooth_row<1>(tile.blue_yellow[1][at], filters.blue_yellow[1], cz.data() + flip_reach);
    smooth_row<1>(tile.gaussian[at], filters.gaussian, y.data() + flip_reach);
    edge_row<1>(tile.edge[at], y.data() + flip_reach);
    point_row<1>(tile.point[at], y.data() + flip_reach);
  }
}

// Clamp to the RGB cube, CIELAB, and the Hunt effect: colours of dark pixels count less.
void see_colours(SeenRow& seen, const TileRow& y, const TileRow& cx, const TileRow& cz) {
  for (std::size_t x = 0; x < tile_width; ++x) {
    std::array<float, 3> rgb{}, response{};
    for (std::size_t c = 0; c < 3; ++c) {
      rgb[c] = std::min(std::max(apply(to_rgb[c], y[x], cx[x], cz[x]), 0.0f), 1.0f);
    }
    for (std::size_t c = 0; c < 3; ++c) {
      response[c] = lab_response(apply(to_xyz[c], rgb[0], rgb[1], rgb[2]));
    }
    const float l = 116.0f * response[1] - 16.0f;
    seen.l[x] = l;
    seen.a[x] = 0.01f * l * 500.0f * (response[0] - response[1]);
    seen.b[x] = 0.01f * l * 200.0f * (response[1] - response[2]);
  }
}

void lengths(TileRow& target, const TileRow& across, const TileRow& down) {
  for (std::size_t x = 0; x < tile_width; ++x) {
    target[x] = std::sqrt(across[x] * across[x] + down[x] * down[x]);
  }
}

// The other half of the filters, at the tile's row `row`.
void filter_down(SeenRow& seen, const Tile& tile, int row) {
  const FlipFilters& filters = flip_filters();
  const auto at = [&](const AcrossPlane& plane) {
    return plane[std::size_t(row) + std::size_t(flip_reach)].data();
  };
  TileRow y, cx, cz, other;
  smooth_row<tile_width>(y, filters.achromatic, at(tile.achromatic));
  smooth_row<tile_width>(cx, filters.red_green, at(tile.red_green));
  smooth_row<tile_width>(cz, filters.blue_yellow[0], at(tile.blue_yellow[0]));
  smooth_row<tile_width>(other, filters.blue_yellow[1], at(tile.blue_yellow[1]));
  const auto& weights = filters.blue_yellow_weights;
  for (std::size_t x = 0; x < tile_width; ++x) cz[x] = weights[0] * cz[x] + weights[1] * other[x];
  see_colours(seen, y, cx, cz);

  TileRow across, down;
  smooth_row<tile_width>(across, filters.gaussian, at(tile.edge));
  edge_row<tile_width>(down, at(tile.gaussian));
  lengths(seen.edge, across, down);
  smooth_row<tile_width>(across, filters.gaussian, at(tile.point));
  point_row<tile_width>(down, at(tile.gaussian));
  lengths(seen.point, across, down);
}

// A row of pixels; a function of its own, through plain pointers, so that the loop vectorises.
void display_row(float* __restrict y, float* __restrict cx, float* __restrict cz, const float* red,
                 const float* green, const float* blue, const float* foreground, std::size_t count,
                 FlipDisplay display) {
  for (std::size_t x = 0; x < count; ++x) {
    const auto shown = [&](float value) {
      const float s = std::min(std::max(display.exposure * value, 0.0f), far_beyond_white);
      const float tone =
          s * (display.a * s + display.b) / (s * (display.c * s + display.d) + display.e);
      return foreground[x] != 0.0f ? std::min(tone, 1.0f) : flip_background;
    };
    const float r = shown(red[x]), g = shown(green[x]), b = shown(blue[x]);
    y[x] = apply(to_opponent[0], r, g, b);
    cx[x] = apply(to_opponent[1], r, g, b);
    cz[x] = apply(to_opponent[2], r, g, b);
  }
}

constexpr float q_c = 0.7f;
constexpr float p_c = 0.4f;
constexpr float p_t = 0.95f;

/// c_max: the largest HyAB distance, that of green and blue, to the power of q_c.
float largest_colour_difference() {
  const auto seen = [](const Rgb& rgb) {
    Lab lab = xyz_to_lab(rgb_to_xyz(rgb));
    lab.a *= 0.01 * lab.l;
    lab.b *= 0.01 * lab.l;
    return lab;
  };
  const Lab green = seen({0.0, 1.0, 0.0});
  const Lab blue = seen({0.0, 0.0, 1.0});
  const double hyab = std::abs(green.l - blue.l) + std::hypot(green.a - blue.a, green.b - blue.b);
  return static_cast<float>(std::pow(hyab, double(q_c)));
}

// HyAB distance, its redistribution to [0, 1], the feature difference, and FLIP itself:
// Delta E_c ^ (1 - Delta E_f), the latter with q_f = 1/2.
void differences(TileRow& flip, const SeenRow& reference, const SeenRow& test, float c_max) {
  const float knee = p_c * c_max;
  const float below = p_t / knee;
  const float above = (1.0f - p_t) / (c_max - knee);
  for (std::size_t x = 0; x < tile_width; ++x) {
    const float a = reference.a[x] - test.a[x];
    const float b = reference.b[x] - test.b[x];
    const float hyab = std::abs(reference.l[x] - test.l[x]) + std::sqrt(a * a + b * b);
    const float power = fast_power(hyab, q_c);
    const float low = below * power;
    const float high = std::min(p_t + above * (power - knee), 1.0f);
    const float colour = power < knee ? low : high;
    const float feature = std::max(std::abs(reference.edge[x] - test.edge[x]),
                                   std::abs(reference.point[x] - test.point[x]));
    flip[x] = fast_power(colour, 1.0f - std::sqrt(0.70710678f * feature));
  }
}

void flip_tile(Plane& map, const FlipImage& reference, const FlipImage& test, int left, int top,
               float c_max) {
  thread_local const auto tiles = std::make_unique<std::array<Tile, 2>>();
  Tile& of_reference = (*tiles)[0];
  Tile& of_test = (*tiles)[1];
  filter_across(of_reference, reference, left, top);
  filter_across(of_test, test, left, top);
  const int rows = std::min(tile_height, reference.height - top);
  const int columns = std::min(tile_width, reference.width - left);
  for (int row = 0; row < rows; ++row) {
    SeenRow reference_row, test_row;
    filter_down(reference_row, of_reference, row);
    filter_down(test_row, of_test, row);
    TileRow flip;
    differences(flip, reference_row, test_row, c_max);
    const auto to = std::ptrdiff_t(top + row) * reference.width + left;
    std::copy_n(flip.begin(), columns, map.begin() + to);
  }
}

}  // namespace

FlipDisplay linear_display(double exposure) {
  return {static_cast<float>(exposure), 0.0f, 1.0f, 0.0f, 0.0f, 1.0f};
}

FlipDisplay aces_display(double exposure) {
  constexpr float built_in = 0.6f;
  return {static_cast<float>(exposure),
          built_in * built_in * 2.51f,
          built_in * 0.03f,
          built_in * built_in * 2.43f,
          built_in * 0.59f,
          0.14f};
}

double inverse_tone(const FlipDisplay& display, double t) {
  // (a - c t) s^2 + (b - d t) s - e t = 0; its positive root in the form that is also good for a
  // line, where the square's factor is 0.
  const double square = display.a - display.c * t;
  const double line = display.b - display.d * t;
  const double constant = display.e * t;
  return 2.0 * constant / (line + std::sqrt(line * line + 4.0 * square * constant));
}

FlipImage flip_image(const PreparedPair& pair, const Planes& radiance, const FlipDisplay& display) {
  FlipImage image{pair.width, pair.height, {}};
  for (Plane& plane : image.opponent) plane.resize(pair.foreground.size());
  for_each_row(pair.height, [&](int row) {
    const auto width = static_cast<std::size_t>(pair.width);
    display_row(row_of(image.opponent[0], row, width), row_of(image.opponent[1], row, width),
                row_of(image.opponent[2], row, width), row_of(radiance[0], row, width),
                row_of(radiance[1], row, width), row_of(radiance[2], row, width),
                row_of(pair.foreground, row, width), width, display);
  });
  return image;
}

Plane flip_map(const FlipImage& reference, const FlipImage& test) {
  const float c_max = largest_colour_difference();
  const int across = (reference.width + tile_width - 1) / tile_width;
  const int down = (reference.height + tile_height - 1) / tile_height;
  Plane map(reference.opponent[0].size());
  for_each_row(
      across * down,
      [&](int tile) {
        flip_tile(map, reference, test, tile % across * tile_width, tile / across * tile_height,
                  c_max);
      },
      std::size_t(tile_width) * tile_height);
  return map;
}

}  // namespace occlab
