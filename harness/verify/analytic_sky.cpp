#include "harness/verify/analytic_sky.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <functional>

#include "renderers/scene/confined_path.h"
#include "renderers/scene/data_root.h"
#include "renderers/scene/error.h"
#include "renderers/shared/equirect.h"

namespace occlab {
namespace {

constexpr std::array<const char*, 5> kinds = {"constant", "linear", "harmonics", "halves", "probe"};

/// Fine enough that what the texels of a linear sky do to an irradiance is below 1e-4 of it.
constexpr int smooth_width = 256;
/// Two halves have nothing to resolve.
constexpr int halves_width = 32;

glm::vec3 colour(const JsonValue& value) {
  const std::vector<double> rgb = value.numbers(3);
  return {float(rgb[0]), float(rgb[1]), float(rgb[2])};
}

/// Texels that hold the radiance of their centres; probe space is the world.
Environment sky_of(const JsonValue& place, std::string name, int width,
                   const std::function<glm::vec3(glm::vec3)>& radiance) {
  Environment environment;
  environment.name = std::move(name);
  const int height = width / 2;
  environment.texels = Image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const glm::vec2 uv((float(x) + 0.5f) / float(width), (float(y) + 0.5f) / float(height));
      const glm::vec3 value = radiance(equirect_direction(uv));
      for (int c = 0; c < 3; ++c) {
        if (!(value[c] >= 0.0f)) {
          place.fail(fmt::format("the radiance is {:g} in some direction; accepted: at least 0",
                                 value[c]));
        }
        environment.texels.at(x, y, c) = value[c];
      }
    }
  }
  return environment;
}

std::string spelled(glm::vec3 value) {
  return fmt::format("({:g} {:g} {:g})", value.x, value.y, value.z);
}

/// L = constant + x w.x + y w.y + z w.z.
Environment linear_sky(const JsonValue& place) {
  place.require_keys({"constant", "x", "y", "z"});
  std::array<glm::vec3, 4> terms{};
  std::string name = "linear";
  constexpr std::array<const char*, 4> keys = {"constant", "x", "y", "z"};
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (const auto term = place.find(keys[i])) terms[i] = colour(*term);
    name += spelled(terms[i]);
  }
  return sky_of(place, name, smooth_width, [&](glm::vec3 w) {
    return terms[0] + terms[1] * w.x + terms[2] * w.y + terms[3] * w.z;
  });
}

/// L = sum c_i y_i(w), up to 16 colours c_i.
Environment harmonic_sky(const JsonValue& place) {
  if (place.array_size() < 1 || place.array_size() > 16) {
    place.fail(fmt::format("found {} colours; accepted: 1 to 16", place.array_size()));
  }
  std::array<glm::vec3, 16> c{};
  std::string name = "harmonics";
  for (std::size_t i = 0; i < place.array_size(); ++i) {
    c[i] = colour(place.element(i));
    name += spelled(c[i]);
  }
  return sky_of(place, name, smooth_width, [&](glm::vec3 w) {
    const Sh4 y = sh_basis(w);
    const std::array<vec4, 4> quarters = {y.c0, y.c1, y.c2, y.c3};
    glm::vec3 sum(0.0f);
    for (std::size_t i = 0; i < 16; ++i) sum += c[i] * quarters[i / 4][int(i % 4)];
    return sum;
  });
}

/// A rotation that takes unit `up` to +Y.
glm::mat3 up_to_pole(glm::vec3 up) {
  const glm::vec3 aside = std::abs(up.x) < 0.6f ? glm::vec3(1, 0, 0) : glm::vec3(0, 0, 1);
  const glm::vec3 x = glm::normalize(aside - glm::dot(aside, up) * up);
  return glm::transpose(glm::mat3(x, up, glm::cross(x, up)));
}

/// One radiance around `up`, another opposite. The border runs along texel edges.
Environment two_halves(const JsonValue& place) {
  place.require_keys({"up", "above", "below"});
  const glm::vec3 above = colour(place.at("above"));
  const glm::vec3 below = colour(place.at("below"));
  const glm::vec3 up = colour(place.at("up"));
  if (!(std::abs(glm::length(up) - 1.0f) < 1e-4f)) {
    place.at("up").fail(
        fmt::format("found a vector of length {:g}; accepted: a unit vector", glm::length(up)));
  }
  Environment sky =
      sky_of(place, fmt::format("halves{}{}{}", spelled(up), spelled(above), spelled(below)),
             halves_width, [&](glm::vec3 w) { return w.y > 0.0f ? above : below; });
  sky.probe_from_world = up_to_pole(glm::normalize(up));
  return sky;
}

}  // namespace

Environment read_analytic_sky(const JsonValue& sky) {
  const std::vector<std::string> keys = sky.keys();
  if (keys.size() != 1) {
    sky.fail(
        fmt::format("found {} keys; accepted: one of {}", keys.size(), fmt::join(kinds, ", ")));
  }
  sky.require_keys({kinds.begin(), kinds.end()});
  const JsonValue value = sky.at(keys.front().c_str());
  if (keys.front() == "linear") return linear_sky(value);
  if (keys.front() == "harmonics") return harmonic_sky(value);
  if (keys.front() == "halves") return two_halves(value);
  if (keys.front() == "probe") {
    const std::string source = value.text();
    return load_environment(
        {.source = is_path(source)
                       ? confined_path(value.file().parent_path(), source, value.where()).string()
                       : source});
  }
  const glm::vec3 radiance = colour(value);
  if (!(std::min({radiance.x, radiance.y, radiance.z}) >= 0.0f)) {
    value.fail("is negative; accepted: at least 0");
  }
  Environment constant = constant_environment(radiance);
  constant.name = "constant" + spelled(radiance);
  return constant;
}

}  // namespace occlab
