#include "renderers/methods/lighting.h"

#include <algorithm>

#include "renderers/scene/punctual.h"

namespace occlab {
namespace {

/// One row more beyond either pole: the nearest row from the other side, so that linear filtering
/// goes on across the pole. Clamped, a surface that faces it would see the light of a direction
/// half a texel off, and rounding would choose which: noise on every level floor.
Image with_rows_beyond_poles(const Image& image) {
  Image padded(image.width(), image.height() + 2, image.channels());
  const auto copy_row = [&](int from, int to, int shift) {
    for (int x = 0; x < image.width(); ++x) {
      std::ranges::copy(image.pixel((x + shift) % image.width(), from),
                        padded.pixel(x, to).begin());
    }
  };
  const int half = image.width() / 2;
  copy_row(0, 0, half);
  for (int y = 0; y < image.height(); ++y) copy_row(y, y + 1, 0);
  copy_row(image.height() - 1, image.height() + 1, half);
  return padded;
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

const Texture& Lighting::probe_texture() const {
  if (!probe_texture_) probe_texture_ = Texture::from_image(environment_.texels);
  return *probe_texture_;
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
