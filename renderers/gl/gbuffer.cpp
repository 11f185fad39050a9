#include "renderers/gl/gbuffer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "renderers/gl/context.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

struct Vertex {
  glm::vec3 position;
  glm::vec3 normal;
  glm::vec2 uv;
};

constexpr std::array<GLint, 3> attribute_sizes = {3, 3, 2};
constexpr std::array<std::size_t, 3> attribute_offsets = {
    offsetof(Vertex, position), offsetof(Vertex, normal), offsetof(Vertex, uv)};

GpuScene::Draw upload(const Mesh& mesh) {
  std::vector<Vertex> vertices(mesh.positions.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    vertices[i] = {mesh.positions[i], mesh.normals[i],
                   mesh.uvs.empty() ? glm::vec2(0.0f) : mesh.uvs[i]};
  }
  GpuScene::Draw draw;
  draw.vertices = Buffer(vertices.data(), vertices.size() * sizeof(Vertex));
  draw.indices = Buffer(mesh.indices.data(), mesh.indices.size() * sizeof(std::uint32_t));
  draw.index_count = GLsizei(mesh.indices.size());
  GLuint id = 0;
  glCreateVertexArrays(1, &id);
  draw.vertex_array = GlObject<delete_vertex_array>(id);
  glVertexArrayVertexBuffer(id, 0, draw.vertices.id(), 0, sizeof(Vertex));
  glVertexArrayElementBuffer(id, draw.indices.id());
  for (GLuint attribute = 0; attribute < attribute_sizes.size(); ++attribute) {
    glEnableVertexArrayAttrib(id, attribute);
    glVertexArrayAttribFormat(id, attribute, attribute_sizes[attribute], GL_FLOAT, GL_FALSE,
                              GLuint(attribute_offsets[attribute]));
    glVertexArrayAttribBinding(id, attribute, 0);
  }
  check_gl("uploading a mesh");
  return draw;
}

/// What a material does not need costs nothing: a shader that may discard tests depth late.
const Program& surface_program(std::string_view fragment_shader, std::string defines,
                               const Material& material, ProgramCache& programs) {
  if (material.albedo_texture) defines += "#define TEXTURED\n";
  if (material.alpha_cutoff) defines += "#define MASKED\n";
  return programs.get("renderers/gl/gbuffer.vert", fragment_shader, defines);
}

void set_material(const Program& program, const Material& material, const GpuScene& gpu_scene) {
  program.set("material_albedo", material.albedo);
  program.set("material_alpha", material.alpha);
  if (material.alpha_cutoff) program.set("alpha_cutoff", *material.alpha_cutoff);
  if (!material.albedo_texture) return;
  program.set("wrap_u", material.sampling.wrap_u);
  program.set("wrap_v", material.sampling.wrap_v);
  program.set("nearest_texel", material.sampling.nearest ? 1 : 0);
  Program::bind_texture(0, gpu_scene.textures()[std::size_t(*material.albedo_texture)]);
}

Image rgb_of(const Image& rgba) {
  if (rgba.empty()) return {};
  Image rgb(rgba.width(), rgba.height(), 3);
  for (std::size_t p = 0; p < rgba.pixel_count(); ++p) {
    for (std::size_t c = 0; c < 3; ++c) rgb.values()[p * 3 + c] = rgba.values()[p * 4 + c];
  }
  return rgb;
}

/// As the passes read them (normal_at() in methods/screen_space.glsl).
Image unit_normals(Image normals) {
  for (std::size_t p = 0; p < normals.values().size(); p += 3) {
    float* n = &normals.values()[p];
    const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (length == 0.0f) continue;  // background
    for (int c = 0; c < 3; ++c) n[c] /= length;
  }
  return normals;
}

/// A surface point that is not finite would send the ray tracer into an endless loop.
void check_finite(const Image& image, const Image& mask, const char* what) {
  if (image.empty()) return;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (mask.at(x, y) == 0.0f) continue;
      for (const float value : image.pixel(x, y)) {
        if (!std::isfinite(value)) {
          throw DeviceError(
              fmt::format("the G-buffer's {} at pixel ({}, {}) is not finite", what, x, y));
        }
      }
    }
  }
}

}  // namespace

glm::mat4 clip_from_view(const View& view) {
  const float near = view.camera.znear;
  const float far = view.camera.zfar;
  const float focal = view.focal_pixels();
  glm::mat4 clip(0.0f);
  clip[0][0] = 2.0f * focal / float(view.width);
  clip[1][1] = -2.0f * focal / float(view.height);
  clip[2][2] = -(far + near) / (far - near);
  clip[2][3] = -1.0f;
  clip[3][2] = -2.0f * far * near / (far - near);
  return clip;
}

void delete_vertex_array(GLuint id) { glDeleteVertexArrays(1, &id); }

GpuScene::GpuScene(const Scene& scene) {
  for (const Mesh& mesh : scene.meshes) draws_.push_back(upload(mesh));
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  for (const Image& texture : scene.textures) {
    if (std::max(texture.width(), texture.height()) > largest) {
      throw DeviceError(fmt::format("{}: a texture has {}x{} texels; this device takes {} a side",
                                    scene.path.string(), texture.width(), texture.height(),
                                    largest));
    }
    textures_.push_back(Texture::from_image(texture));
  }
}

void draw_surfaces(const Scene& scene, const GpuScene& gpu_scene, const glm::mat4& view_from_world,
                   const glm::mat4& clip_from_view, std::string_view fragment_shader,
                   ProgramCache& programs, const SurfaceVariant& variant) {
  const Program* program = nullptr;
  for (const Instance& instance : scene.instances) {
    const Mesh& mesh = scene.meshes[std::size_t(instance.mesh)];
    const Material& material = scene.materials[std::size_t(mesh.material)];
    const Program& needed = surface_program(fragment_shader, variant.defines, material, programs);
    if (&needed != program) {
      program = &needed;
      program->use();
      program->set("clip_from_view", clip_from_view);
      if (variant.set) variant.set(*program);
    }
    const glm::mat4 view_from_object = view_from_world * instance.world_from_object;
    program->set("view_from_object", view_from_object);
    program->set("normal_from_object", glm::transpose(glm::inverse(glm::mat3(view_from_object))));
    // Clip y points down, which turns triangles round; a mirrored instance turns them back.
    const bool mirrored = glm::determinant(glm::mat3(view_from_object)) < 0.0f;
    glFrontFace(mirrored ? GL_CCW : GL_CW);
    set_material(*program, material, gpu_scene);
    const GpuScene::Draw& draw = gpu_scene.draws()[std::size_t(instance.mesh)];
    glBindVertexArray(draw.vertex_array.id());
    glDrawElements(GL_TRIANGLES, draw.index_count, GL_UNSIGNED_INT, nullptr);
  }
  glFrontFace(GL_CCW);
}

void clear_for_surfaces() {
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glClearColor(0.0f, 0.0f, 0.0f, 0.0f);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void draw_gbuffer(const Framebuffer& targets, const Scene& scene, const GpuScene& gpu_scene,
                  const View& view, ProgramCache& programs) {
  targets.bind();
  clear_for_surfaces();
  draw_surfaces(scene, gpu_scene, view.view_from_world(), clip_from_view(view), gbuffer_shader,
                programs);
  check_gl("the G-buffer pass");
}

GBuffer render_gbuffer(const Scene& scene, const GpuScene& gpu_scene, const View& view,
                       GBufferBits bits, ProgramCache& programs) {
  const GLenum geometry = bits == GBufferBits::float32 ? GL_RGBA32F : GL_RGBA16F;
  const std::array<GLenum, 4> formats = {geometry, geometry, GL_RGBA32F, GL_RGBA32F};
  GBuffer gbuffer{Framebuffer(view.width, view.height, formats, true)};
  draw_gbuffer(gbuffer.targets, scene, gpu_scene, view, programs);
  return gbuffer;
}

GBufferImages gbuffer_images(const Image& position, const Image& normal,
                             const Image& geometric_normal, const Image& albedo, GLenum format) {
  Image mask(position.width(), position.height(), 1);
  for (std::size_t p = 0; p < mask.pixel_count(); ++p) {
    mask.values()[p] = position.values()[p * 4 + 3];
  }
  Image normals = rgb_of(normal);
  GBufferImages images{rgb_of(position),
                       format == GL_RGBA16F ? unit_normals(std::move(normals)) : std::move(normals),
                       rgb_of(geometric_normal), rgb_of(albedo), std::move(mask)};
  check_finite(images.position_view, images.mask, "position");
  check_finite(images.normal_view, images.mask, "normal");
  check_finite(images.geometric_normal_view, images.mask, "geometric normal");
  return images;
}

GBufferImages download(const GBuffer& gbuffer) {
  return gbuffer_images(gbuffer.position_view().download(), gbuffer.normal_view().download(),
                        gbuffer.geometric_normal_view().download(), gbuffer.albedo().download(),
                        gbuffer.normal_view().format());
}

}  // namespace occlab
