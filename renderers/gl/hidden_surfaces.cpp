#include "renderers/gl/hidden_surfaces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "renderers/gl/context.h"

namespace occlab {
namespace {

constexpr const char* positions_only = "#define POSITIONS_ONLY\n";

std::string defines_of(const HiddenSettings& settings) {
  std::string defines =
      settings.kind == HiddenKind::layers ? "#define PEELED\n" : "#define OTHER_EYE\n";
  if (!settings.complete) defines += positions_only;
  return defines;
}

/// The camera that looks from `eye` at `target`, both in the space of the view's camera, whose up
/// is up unless it looks straight along it.
HiddenCamera looking_at(const View& view, glm::vec3 eye, glm::vec3 target, float scale) {
  const glm::vec3 forward = glm::normalize(target - eye);
  const bool straight = std::abs(forward.y) > 0.999f;
  const glm::vec3 up = straight ? glm::vec3(0, 0, -1) : glm::vec3(0, 1, 0);
  const glm::mat4 camera_from_view = glm::lookAt(eye, target, up);
  HiddenCamera camera{view, camera_from_view};
  camera.view.camera.world_from_camera =
      view.camera.world_from_camera * glm::inverse(camera_from_view);
  camera.view.camera.zfar += glm::length(eye);
  camera.view.width = std::max(1, int(std::lround(scale * float(view.width))));
  camera.view.height = std::max(1, int(std::lround(scale * float(view.height))));
  return camera;
}

}  // namespace

std::vector<HiddenCamera> hidden_cameras(const View& view, const HiddenSettings& settings,
                                         float bounding_radius, glm::vec3 center_view) {
  std::vector<HiddenCamera> cameras;
  for (int i = 0; i < settings.count; ++i) {
    const float angle = glm::pi<float>() * (float(i) + 0.5f) / float(settings.count);
    const glm::vec3 displacement(std::cos(angle), std::sin(angle), 0.0f);
    cameras.push_back(looking_at(view, settings.camera_offset * bounding_radius * displacement,
                                 center_view, settings.camera_scale));
  }
  return cameras;
}

glm::vec3 center_of_interest(const GBuffer& first, const View& view, const Scene& scene) {
  const glm::vec4 seen = first.position_view().texel(view.width / 2, view.height / 2);
  if (seen.w > 0.0f) return glm::vec3(seen);
  const glm::vec3 middle_world = 0.5f * (scene.bounds_min + scene.bounds_max);
  const glm::vec3 middle(view.view_from_world() * glm::vec4(middle_world, 1.0f));
  return {0.0f, 0.0f, std::min(middle.z, -view.camera.znear)};
}

HiddenSurfaces::HiddenSurfaces(const Scene& scene, const View& view, const GBuffer& first,
                               const HiddenSettings& settings)
    : settings_(settings) {
  int width = view.width;
  int height = view.height;
  if (settings.kind == HiddenKind::cameras) {
    cameras_ = hidden_cameras(view, settings, scene.bounding_radius(),
                              center_of_interest(first, view, scene));
    width = cameras_.front().view.width;
    height = cameras_.front().view.height;
  }
  const GLenum geometry = settings.bits == GBufferBits::float32 ? GL_RGBA32F : GL_RGBA16F;
  const std::array<GLenum, 4> formats = {geometry, geometry, GL_RGBA32F, GL_RGBA32F};
  const std::size_t targets = settings.complete ? formats.size() : 1;
  for (std::size_t i = 0; i < targets; ++i) {
    arrays_.push_back(Texture::array(width, height, settings.count, formats[i]));
  }
  for (int i = 0; i < 2; ++i) depths_.emplace_back(width, height, GL_DEPTH_COMPONENT32F);
  std::vector<const Texture*> arrays;
  for (const Texture& array : arrays_) arrays.push_back(&array);
  for (int i = 0; i < settings.count; ++i) {
    targets_.emplace_back(arrays, i, &depths_[std::size_t(i % 2)]);
  }
}

void HiddenSurfaces::draw(const Scene& scene, const GpuScene& gpu_scene, const View& view,
                          const GBuffer& first, ProgramCache& programs) const {
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    SurfaceVariant variant{.defines = defines_of(settings_), .set = {}};
    glm::mat4 clip = clip_from_view(view);
    if (settings_.kind == HiddenKind::layers) {
      const Texture& previous = i == 0 ? first.targets.depth() : depths_[(i - 1) % 2];
      variant.set = [&previous](const Program&) { Program::bind_texture(1, previous); };
    } else {
      const HiddenCamera& camera = cameras_[i];
      clip = clip_from_view(camera.view) * camera.camera_from_view;
      const glm::vec3 eye(glm::inverse(camera.camera_from_view)[3]);
      variant.set = [eye](const Program& program) { program.set("eye_view", eye); };
    }
    targets_[i].bind();
    clear_for_surfaces();
    draw_surfaces(scene, gpu_scene, view.view_from_world(), clip, gbuffer_shader, programs,
                  variant);
  }
  check_gl("drawing hidden surfaces");
}

HiddenImages download(const HiddenSurfaces& hidden) {
  HiddenImages result{.images = {}, .cameras = hidden.cameras()};
  const bool complete = hidden.settings().complete;
  for (int i = 0; i < hidden.settings().count; ++i) {
    const Image position = hidden.position_view().download_layer(i);
    const auto more = [&](const Texture& (HiddenSurfaces::*array)() const) {
      return complete ? (hidden.*array)().download_layer(i) : Image();
    };
    result.images.push_back(gbuffer_images(
        position, more(&HiddenSurfaces::normal_view), more(&HiddenSurfaces::geometric_normal_view),
        more(&HiddenSurfaces::albedo), hidden.position_view().format()));
  }
  return result;
}

Image sides_of_first(const Scene& scene, const GpuScene& gpu_scene, const View& view,
                     ProgramCache& programs) {
  const std::array<GLenum, 1> format = {GL_RGBA32F};
  const Framebuffer target(view.width, view.height, format, true);
  target.bind();
  clear_for_surfaces();
  const SurfaceVariant variant{
      .defines = std::string("#define OTHER_EYE\n") + positions_only,
      .set = [](const Program& program) { program.set("eye_view", glm::vec3(0.0f)); }};
  draw_surfaces(scene, gpu_scene, view.view_from_world(), clip_from_view(view), gbuffer_shader,
                programs, variant);
  const Image position = target.colors().front().download();
  Image sides(position.width(), position.height(), 1);
  for (std::size_t p = 0; p < sides.pixel_count(); ++p) {
    sides.values()[p] = position.values()[p * 4 + 3];
  }
  return sides;
}

}  // namespace occlab
