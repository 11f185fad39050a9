#include "harness/figures/lobes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "harness/figures/canvas.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr int direction_count = 4096;
constexpr int smallest_size = 16;
constexpr int subpixels = 2;     // each way
constexpr int march_steps = 96;  // through the sphere of the lobe's reach
constexpr double rim = 0.95;     // of the half image: where the reach is
constexpr DisplayColour positive = {0.80f, 0.13f, 0.10f};
constexpr DisplayColour negative = {0.13f, 0.30f, 0.78f};
constexpr DisplayColour circle = {0.78f, 0.78f, 0.78f};

/// Direction `i` of the Fibonacci lattice.
glm::vec3 lattice_direction(int i) {
  const double golden = 2.399963229728653;
  const double z = 1.0 - (2.0 * i + 1.0) / direction_count;
  const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
  return {float(r * std::cos(golden * i)), float(r * std::sin(golden * i)), float(z)};
}

double value(const Sh4& f, const glm::dvec3& d) { return sh_dot(f, sh_basis(glm::vec3(d))); }

/// The largest |f(d)| of three functions.
double distance_of(const ShRgb& f, const glm::dvec3& d) {
  const glm::vec3 found = glm::abs(sh_dot_rgb(f, sh_basis(glm::vec3(d))));
  return double(std::max({found.x, found.y, found.z}));
}
double distance_of(const Sh4& f, const glm::dvec3& d) { return std::abs(value(f, d)); }

void check(int size, double scale, const char* what) {
  if (size < smallest_size) {
    throw InputError(
        fmt::format("a lobe of {} pixels; accepted are {} or more", size, smallest_size));
  }
  if (!(scale > 0.0) || !std::isfinite(scale)) {
    throw InputError(fmt::format("the {} of a lobe is {:g}; accepted is above 0", what, scale));
  }
}

/// Positive inside of the surface.
template <typename Function>
double depth_inside(const Function& f, const glm::dvec3& p) {
  const double distance = glm::length(p);
  if (distance == 0.0) return 1.0;
  return distance_of(f, p / distance) - distance;
}

/// The surface's point in front of the rest at a place of the image.
template <typename Function>
std::optional<glm::dvec3> front_point(const Function& f, double x, double y, double reach) {
  const double squared = reach * reach - x * x - y * y;
  if (squared <= 0.0) return std::nullopt;
  const double front = std::sqrt(squared);
  double outside = front;
  for (int step = 1; step <= march_steps; ++step) {
    double inside = front * (1.0 - 2.0 * step / march_steps);
    if (depth_inside(f, {x, y, inside}) < 0.0) {
      outside = inside;
      continue;
    }
    for (int i = 0; i < 20; ++i) {
      const double middle = 0.5 * (outside + inside);
      (depth_inside(f, {x, y, middle}) < 0.0 ? outside : inside) = middle;
    }
    return glm::dvec3(x, y, inside);
  }
  return std::nullopt;
}

template <typename Function>
glm::dvec3 normal_at(const Function& f, const glm::dvec3& p, double reach) {
  const double h = 1e-3 * reach;
  glm::dvec3 gradient;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 step(0.0);
    step[axis] = h;
    gradient[axis] = depth_inside(f, p - step) - depth_inside(f, p + step);
  }
  return glm::normalize(gradient);
}

DisplayColour shaded(const DisplayColour& colour, const glm::dvec3& normal) {
  const glm::dvec3 light = glm::normalize(glm::dvec3(-0.4, 0.6, 0.7));
  const double diffuse = std::max(0.0, glm::dot(normal, light));
  const double gloss = 0.25 * std::pow(diffuse, 24.0);
  DisplayColour result{};
  for (std::size_t c = 0; c < 3; ++c) {
    result[c] = float(std::clamp(colour[c] * (0.35 + 0.75 * diffuse) + gloss, 0.0, 1.0));
  }
  return result;
}

/// Every pixel is the mean of its subpixels' colours; `colour` is asked at places in units of the
/// reach, +Y up.
template <typename Colour>
Image draw(int size, Colour colour) {
  Image image = blank(size, size);
  const double scale = 2.0 / (rim * size);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      std::array<double, 3> sum{};
      for (int sub = 0; sub < subpixels * subpixels; ++sub) {
        const int row = sub / subpixels;
        const double px = x + (sub % subpixels + 0.5) / subpixels - 0.5 * size;
        const double py = y + (row + 0.5) / subpixels - 0.5 * size;
        const DisplayColour found = colour(scale * px, -scale * py);
        for (std::size_t c = 0; c < 3; ++c) sum[c] += found[c];
      }
      for (std::size_t c = 0; c < 3; ++c) {
        image.at(x, y, int(c)) = float(sum[c] / (subpixels * subpixels));
      }
    }
  }
  return image;
}

float srgb(double linear) {
  const double v = std::clamp(linear, 0.0, 1.0);
  return float(v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055);
}

template <typename Function>
double reach_of(const Function& f) {
  double reach = 0.0;
  for (int i = 0; i < direction_count; ++i) {
    reach = std::max(reach, distance_of(f, glm::dvec3(lattice_direction(i))));
  }
  return reach;
}

/// The surface where it is in front, in the colour that `colour` gives a direction.
template <typename Function, typename Colour>
Image draw_surface(const Function& f, double reach, int size, Colour colour) {
  check(size, reach, "reach");
  const double own = std::min(1.02 * reach_of(f), 1.0 / rim * reach);
  const double line = 1.5 / (0.5 * rim * size);  // the circle's thickness, in reaches
  return draw(size, [&](double x, double y) {
    if (const auto point = front_point(f, x * reach, y * reach, own)) {
      return shaded(colour(glm::normalize(*point)), normal_at(f, *point, reach));
    }
    return std::abs(std::hypot(x, y) - 1.0) < 0.5 * line ? circle : paper;
  });
}

}  // namespace

double lobe_reach(const Sh4& f) { return reach_of(f); }
double colour_lobe_reach(const ShRgb& f) { return reach_of(f); }

double light_reach(const ShRgb& light) {
  double reach = 0.0;
  for (int i = 0; i < direction_count; ++i) {
    const glm::vec3 found = sh_dot_rgb(light, sh_basis(lattice_direction(i)));
    reach = std::max({reach, double(found.x), double(found.y), double(found.z)});
  }
  return reach;
}

Image draw_lobe(const Sh4& f, double reach, int size) {
  return draw_surface(f, reach, size, [&](const glm::dvec3& d) {
    return value(f, d) >= 0.0 ? positive : negative;
  });
}

Image draw_colour_lobe(const ShRgb& f, double reach, int size) {
  return draw_surface(f, reach, size, [&](const glm::dvec3& d) {
    const glm::vec3 found = glm::max(sh_dot_rgb(f, sh_basis(glm::vec3(d))), glm::vec3(0.0f));
    const float largest = std::max({found.x, found.y, found.z, 1e-20f});
    return DisplayColour{srgb(double(found.x / largest)), srgb(double(found.y / largest)),
                         srgb(double(found.z / largest))};
  });
}

Image draw_light_sphere(const ShRgb& light, double white, int size) {
  check(size, white, "white");
  return draw(size, [&](double x, double y) {
    const double squared = 1.0 - x * x - y * y;
    if (squared < 0.0) return paper;
    const glm::vec3 d(float(x), float(y), float(std::sqrt(squared)));
    const glm::vec3 found = sh_dot_rgb(light, sh_basis(d));
    return DisplayColour{srgb(found.x / white), srgb(found.y / white), srgb(found.z / white)};
  });
}

}  // namespace occlab
