#include "renderers/methods/lighting.h"

#include "renderers/scene/punctual.h"

namespace occlab {

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

const Texture& Lighting::cone_texture() const {
  if (!cone_texture_) {
    const ConePrefilter cones = prefilter_cones(environment_, cone_levels, cone_level_width);
    cone_texture_ = Texture::from_equirect_levels(cones.levels);
  }
  return *cone_texture_;
}

const Buffer& Lighting::light_buffer() const {
  if (!light_buffer_) {
    std::vector<PunctualLight> lights;
    for (const Light& light : lights_) {
      lights.push_back(punctual_light(light, view_.view_from_world()));
    }
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
