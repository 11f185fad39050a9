#include "renderers/methods/lighting.h"

#include <algorithm>
#include <glm/glm.hpp>

#include "renderers/methods/octahedral_map.h"
#include "renderers/scene/punctual.h"
#include "renderers/shared/packed_radiance.h"

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

const Image& Lighting::octahedral_probe() const {
  if (!octahedral_probe_) octahedral_probe_ = octahedral_map(environment_);
  return *octahedral_probe_;
}

const TexelBuffer& Lighting::octahedral_texels() const {
  if (!octahedral_texels_) {
    const Image& map = octahedral_probe();
    std::vector<glm::uvec2> texels;
    texels.reserve(map.pixel_count());
    for (int y = 0; y < map.height(); ++y) {
      for (int x = 0; x < map.width(); ++x) {
        const auto texel = map.pixel(x, y);
        texels.push_back(pack_radiance({texel[0], texel[1], texel[2]}));
      }
    }
    octahedral_texels_.emplace(GL_RG32UI, texels.data(), texels.size() * sizeof(glm::uvec2));
  }
  return *octahedral_texels_;
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
