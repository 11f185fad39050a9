#include "renderers/methods/lighting.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "renderers/scene/parallel.h"
#include "renderers/scene/punctual.h"
#include "renderers/shared/equirect.h"
#include "renderers/shared/octahedral.h"

namespace occlab {
namespace {

/// One row more beyond either pole, so that linear filtering gives every direction at the pole the
/// mean of the row around it: a texel t of that row has 2 mean - t beyond it. With the row
/// repeated, or that of the other side, the pole's value would depend on a direction's last bits:
/// noise on every level floor.
Image with_rows_beyond_poles(const Image& image) {
  Image padded(image.width(), image.height() + 2, image.channels());
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      std::ranges::copy(image.pixel(x, y), padded.pixel(x, y + 1).begin());
    }
  }
  const auto reflect = [&](int from, int to) {
    for (int c = 0; c < image.channels(); ++c) {
      double sum = 0.0;
      for (int x = 0; x < image.width(); ++x) sum += double(image.at(x, from, c));
      const float mean = float(sum / image.width());
      for (int x = 0; x < image.width(); ++x) {
        padded.at(x, to, c) = 2.0f * mean - image.at(x, from, c);
      }
    }
  };
  reflect(0, 0);
  reflect(image.height() - 1, image.height() + 1);
  return padded;
}

/// Radiance over an octahedral texel, at across x across points.
struct TexelRadiance {
  glm::vec3 mean{0.0f};  ///< over the solid angle
  float contrast = 0.0f;
};

TexelRadiance texel_radiance(const Image& equirect, int side, glm::ivec2 place, int across) {
  glm::vec3 sum(0.0f);
  glm::vec3 least(std::numeric_limits<float>::infinity());
  glm::vec3 most(0.0f);
  float weights = 0.0f;
  for (int i = 0; i < across * across; ++i) {
    const glm::vec2 within = (glm::vec2(i % across, i / across) + 0.5f) / float(across);
    const glm::vec3 point = octahedral_point((glm::vec2(place) + within) / float(side));
    const float distance = length(point);
    const float solid_angle = 1.0f / (distance * distance * distance);
    const glm::vec2 uv = equirect_uv(point / distance);
    const int x = std::min(int(uv.x * float(equirect.width())), equirect.width() - 1);
    const int y = std::min(int(uv.y * float(equirect.height())), equirect.height() - 1);
    const auto texel = equirect.pixel(x, y);
    const glm::vec3 radiance(texel[0], texel[1], texel[2]);
    sum += solid_angle * radiance;
    weights += solid_angle;
    least = min(least, radiance);
    most = max(most, radiance);
  }
  const glm::vec3 contrast = most - least;
  return {sum / weights, std::max({contrast.x, contrast.y, contrast.z})};
}

float mean_value(const Image& image) {
  double sum = 0.0;
  for (const float value : image.values()) sum += double(value);
  return float(sum / double(image.values().size()));
}

/// The outlines of what is bright, such as a sun of few texels, are looked at closely.
Image octahedral_map(const Image& equirect, int side) {
  constexpr int points_across = 4;
  constexpr int points_across_outlines = 32;
  const float bright = mean_value(equirect);
  Image map(side, side, 3);
  parallel_for(std::size_t(side), [&](std::size_t row) {
    for (int x = 0; x < side; ++x) {
      const glm::ivec2 place(x, int(row));
      TexelRadiance texel = texel_radiance(equirect, side, place, points_across);
      if (texel.contrast > bright) {
        texel = texel_radiance(equirect, side, place, points_across_outlines);
      }
      for (int c = 0; c < 3; ++c) map.at(x, int(row), c) = texel.mean[c];
    }
  });
  return map;
}

}  // namespace

Lighting::Lighting(Environment environment, std::vector<Light> lights, const View& view)
    : environment_(std::move(environment)), lights_(std::move(lights)), view_(view) {}

glm::mat3 Lighting::probe_from_view() const {
  return environment_.probe_from_world * view_.world_from_view_rotation();
}

const ShRgb& Lighting::sh_view() const {
  if (!sh_view_) sh_view_ = project_sh(environment_, view_.world_from_view_rotation());
  return *sh_view_;
}

int Lighting::octahedral_side() const {
  // Texels of about the size of the probe's own at its equator; small ones keep their outlines, and
  // the map stays small enough for caches.
  constexpr unsigned least = 512;
  constexpr unsigned most = 2048;
  const auto width = unsigned(environment_.texels.width());
  return int(std::clamp(std::bit_ceil(width) / 2, least, most));
}

const Image& Lighting::octahedral_probe() const {
  if (!octahedral_probe_) {
    octahedral_probe_ = octahedral_map(environment_.texels, octahedral_side());
  }
  return *octahedral_probe_;
}

const Texture& Lighting::octahedral_texture() const {
  if (!octahedral_texture_) octahedral_texture_ = Texture::from_image(octahedral_probe());
  return *octahedral_texture_;
}

const std::vector<Image>& Lighting::cones() const {
  if (!cones_) {
    cones_ = prefilter_cones(environment_, cone_levels, cone_level_width).levels;
    for (Image& level : *cones_) level = with_rows_beyond_poles(level);
  }
  return *cones_;
}

const Texture& Lighting::cone_texture() const {
  if (!cone_texture_) cone_texture_ = Texture::from_equirect_levels(cones());
  return *cone_texture_;
}

std::vector<PunctualLight> Lighting::lights_view() const {
  std::vector<PunctualLight> lights;
  for (const Light& light : lights_) {
    lights.push_back(punctual_light(light, view_.view_from_world()));
  }
  return lights;
}

const Buffer& Lighting::light_buffer() const {
  if (!light_buffer_) {
    std::vector<PunctualLight> lights = lights_view();
    if (lights.empty()) lights.push_back({});
    light_buffer_ = Buffer(lights.data(), lights.size() * sizeof(PunctualLight));
  }
  return *light_buffer_;
}

const Buffer& Lighting::sh_buffer() const {
  if (!sh_buffer_) sh_buffer_ = Buffer(&sh_view(), sizeof(ShRgb));
  return *sh_buffer_;
}

}  // namespace occlab
