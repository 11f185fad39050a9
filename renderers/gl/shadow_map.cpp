#include "renderers/gl/shadow_map.h"

#include <fmt/format.h>

#include <array>
#include <cassert>
#include <cmath>

#include "renderers/gl/context.h"
#include "renderers/scene/error.h"
#include "renderers/shared/frame.h"

namespace occlab {
namespace {

/// Depth from 1 nearby to 0 far away, which floats hold evenly at every distance, while it lives.
class ReversedDepth {
 public:
  ReversedDepth() {
    glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
    glDisable(GL_CULL_FACE);
  }
  ~ReversedDepth() {
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glDepthFunc(GL_LESS);
  }
  ReversedDepth(const ReversedDepth&) = delete;
  ReversedDepth& operator=(const ReversedDepth&) = delete;
};

/// Turns `axis` to -Z.
glm::mat3 looking_along(glm::vec3 axis) { return glm::transpose(tangent_frame(-axis)); }

glm::mat4 moved_to_origin(glm::vec3 position) {
  glm::mat4 matrix(1.0f);
  matrix[3] = glm::vec4(-position, 1.0f);
  return matrix;
}

glm::mat4 clip_from_face(const LightProjection& projection) {
  const float width = projection.high - projection.low;
  const float center = (projection.high + projection.low) / width;
  glm::mat4 clip(0.0f);
  clip[0][0] = clip[1][1] = 2.0f / width;
  if (projection.parallel) {
    clip[3] = glm::vec4(-center, -center, 1.0f, 1.0f);
    clip[2][2] = 1.0f / projection.farthest;
  } else {
    clip[2] = glm::vec4(center, center, 0.0f, -1.0f);
    clip[3][2] = projection.nearest;
  }
  return clip;
}

glm::mat4 face_from_world(const LightProjection& projection, int face) {
  return glm::mat4(projection.face_from_light[std::size_t(face)]) * projection.light_from_world;
}

void check_side(int side) {
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  if (side > largest) {
    throw DeviceError(
        fmt::format("shadow_map_side is {}; this device takes textures of up to {} texels a side",
                    side, largest));
  }
}

/// Turns normals to the side that light which travels along `travel` comes to.
void face_light(GBufferImages& seen, const LightProjection& projection) {
  for (int y = 0; y < seen.mask.height(); ++y) {
    for (int x = 0; x < seen.mask.width(); ++x) {
      const auto p = seen.position_view.pixel(x, y);
      const glm::vec3 travel =
          projection.parallel ? glm::vec3(0, 0, -1) : glm::vec3(p[0], p[1], p[2]);
      const auto geometric = seen.geometric_normal_view.pixel(x, y);
      const auto shading = seen.normal_view.pixel(x, y);
      const auto turn = [](auto normal) {
        for (float& value : normal) value = -value;
      };
      if (glm::dot(glm::vec3(geometric[0], geometric[1], geometric[2]), travel) <= 0.0f) continue;
      turn(geometric);
      turn(shading);
    }
  }
}

}  // namespace

LightProjection cube_projection(glm::vec3 position_world, float nearest) {
  LightProjection projection{.light_from_world = moved_to_origin(position_world),
                             .nearest = nearest};
  for (const glm::vec3& axis : {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1)}) {
    for (const float sign : {1.0f, -1.0f}) {
      projection.face_from_light.push_back(looking_along(sign * axis));
    }
  }
  return projection;
}

LightProjection half_space_projection(glm::vec3 position_world, glm::vec3 axis_world,
                                      float nearest) {
  // A cube's corner points along the axis. Of directions with x + y + z >= 0 whose largest
  // component is x, y and z are from -2x to x.
  const float third = std::sqrt(1.0f / 3.0f);
  const glm::mat3 from_axis = tangent_frame(axis_world);
  const glm::mat3 from_corner = tangent_frame(glm::vec3(third));
  LightProjection projection{
      .light_from_world =
          glm::mat4(from_corner * glm::transpose(from_axis)) * moved_to_origin(position_world),
      .low = -2.0f,
      .high = 1.0f,
      .nearest = nearest};
  for (int i = 0; i < 3; ++i) {
    glm::mat3 light_from_face(0.0f);
    light_from_face[0][(i + 2) % 3] = 1.0f;
    light_from_face[1][(i + 1) % 3] = 1.0f;
    light_from_face[2][i] = -1.0f;
    projection.face_from_light.push_back(glm::transpose(light_from_face));
  }
  return projection;
}

LightProjection cone_projection(glm::vec3 position_world, glm::vec3 axis_world, float half_angle,
                                float nearest) {
  const float tangent = std::tan(half_angle);
  return {.light_from_world = moved_to_origin(position_world),
          .face_from_light = {looking_along(axis_world)},
          .low = -tangent,
          .high = tangent,
          .nearest = nearest};
}

LightProjection parallel_projection(glm::vec3 direction_world, glm::vec3 center_world,
                                    float radius) {
  return {.light_from_world = moved_to_origin(center_world - radius * direction_world),
          .face_from_light = {looking_along(direction_world)},
          .low = -radius,
          .high = radius,
          .parallel = true,
          .farthest = 2.0f * radius};
}

ShadowMaps::ShadowMaps(int side, int faces) {
  assert(faces >= 1 && faces <= LightProjection::most_faces);
  check_side(side);
  distance_ = Texture::array(side, side, faces, GL_R32F);
  depth_ = Texture(side, side, GL_DEPTH_COMPONENT32F);
  const std::array<const Texture*, 1> arrays = {&distance_};
  for (int face = 0; face < faces; ++face) targets_.emplace_back(arrays, face, &depth_);
}

void ShadowMaps::draw(const LightProjection& projection, const Scene& scene,
                      const GpuScene& gpu_scene, ProgramCache& programs) const {
  assert(projection.faces() <= faces());
  const ReversedDepth reversed;
  const glm::mat4 clip = clip_from_face(projection);
  const SurfaceVariant variant{.defines = projection.parallel ? "#define PARALLEL_RAYS\n" : ""};
  for (int face = 0; face < projection.faces(); ++face) {
    targets_[std::size_t(face)].bind();
    const std::array<GLfloat, 4> nothing = {no_surface, 0.0f, 0.0f, 0.0f};
    const GLfloat far_away = 0.0f;
    glClearBufferfv(GL_COLOR, 0, nothing.data());
    glClearBufferfv(GL_DEPTH, 0, &far_away);
    draw_surfaces(scene, gpu_scene, face_from_world(projection, face), clip,
                  "renderers/gl/shadow_map.frag", programs, variant);
  }
  check_gl("a shadow map");
}

GBufferImages reflective_shadow_map(const LightProjection& projection, int face, int side,
                                    const Scene& scene, const GpuScene& gpu_scene,
                                    ProgramCache& programs) {
  check_side(side);
  const std::array<GLenum, 4> formats = {GL_RGBA32F, GL_RGBA32F, GL_RGBA32F, GL_RGBA32F};
  const GBuffer seen{Framebuffer(side, side, formats, true)};
  {
    const ReversedDepth reversed;
    seen.targets.bind();
    glClearColor(0.0f, 0.0f, 0.0f, 0.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    const GLfloat far_away = 0.0f;
    glClearBufferfv(GL_DEPTH, 0, &far_away);
    draw_surfaces(scene, gpu_scene, face_from_world(projection, face), clip_from_face(projection),
                  gbuffer_shader, programs);
    check_gl("a reflective shadow map");
  }
  GBufferImages images = download(seen);
  face_light(images, projection);
  return images;
}

}  // namespace occlab
