#include "renderers/gl/texture.h"

#include <fmt/format.h>

#include <algorithm>

#include "renderers/gl/context.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

GLuint create_texture(GLenum target, GLint filter, GLint wrap_u) {
  GLuint id = 0;
  glCreateTextures(target, 1, &id);
  glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, filter);
  glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, filter);
  glTextureParameteri(id, GL_TEXTURE_WRAP_S, wrap_u);
  glTextureParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return id;
}

std::vector<float> rgba(const Image& image) {
  std::vector<float> values;
  values.reserve(image.pixel_count() * 4);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int c = 0; c < 4; ++c) {
        values.push_back(c < image.channels() ? image.at(x, y, c) : (c == 3 ? 1.0f : 0.0f));
      }
    }
  }
  return values;
}

void set_draw_buffers(GLuint framebuffer, std::size_t count) {
  std::vector<GLenum> attachments;
  for (GLenum i = 0; i < count; ++i) attachments.push_back(GL_COLOR_ATTACHMENT0 + i);
  glNamedFramebufferDrawBuffers(framebuffer, GLsizei(count), attachments.data());
}

void check_complete(GLuint framebuffer, int width, int height) {
  const GLenum status = glCheckNamedFramebufferStatus(framebuffer, GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) {
    throw DeviceError(
        fmt::format("OpenGL refuses a {}x{} framebuffer: status 0x{:04x}", width, height, status));
  }
}

}  // namespace

void delete_texture(GLuint id) { glDeleteTextures(1, &id); }
void delete_framebuffer(GLuint id) { glDeleteFramebuffers(1, &id); }
void delete_buffer(GLuint id) { glDeleteBuffers(1, &id); }

Texture::Texture(int width, int height, GLenum internal_format)
    : object_(create_texture(GL_TEXTURE_2D, GL_NEAREST, GL_CLAMP_TO_EDGE)),
      width_(width),
      height_(height),
      format_(internal_format) {
  glTextureStorage2D(id(), 1, internal_format, width, height);
  check_gl("allocating a texture");
}

Texture Texture::array(int width, int height, int layers, GLenum internal_format) {
  Texture texture;
  texture.object_ =
      GlObject<delete_texture>(create_texture(GL_TEXTURE_2D_ARRAY, GL_NEAREST, GL_CLAMP_TO_EDGE));
  texture.width_ = width;
  texture.height_ = height;
  texture.format_ = internal_format;
  glTextureStorage3D(texture.id(), 1, internal_format, width, height, layers);
  check_gl("allocating a texture array");
  return texture;
}

Texture Texture::from_image(const Image& image) {
  Texture texture(image.width(), image.height(), GL_RGBA32F);
  texture.upload(image);
  return texture;
}

void Texture::upload(const Image& image) const {
  assert(image.width() == width_ && image.height() == height_);
  glTextureSubImage2D(id(), 0, 0, 0, width_, height_, GL_RGBA, GL_FLOAT, rgba(image).data());
  check_gl("uploading a texture");
}

void Texture::upload_integers(const std::uint32_t* values) const {
  glTextureSubImage2D(id(), 0, 0, 0, width_, height_, GL_RGBA_INTEGER, GL_UNSIGNED_INT, values);
  check_gl("uploading an integer texture");
}

Texture Texture::from_equirect_levels(std::span<const Image> levels) {
  const Image& first = levels.front();
  Texture texture;
  texture.object_ =
      GlObject<delete_texture>(create_texture(GL_TEXTURE_2D_ARRAY, GL_LINEAR, GL_REPEAT));
  texture.width_ = first.width();
  texture.height_ = first.height();
  texture.format_ = GL_RGBA32F;
  glTextureStorage3D(texture.id(), 1, GL_RGBA32F, first.width(), first.height(),
                     GLsizei(levels.size()));
  for (std::size_t level = 0; level < levels.size(); ++level) {
    assert(levels[level].same_size(first));
    glTextureSubImage3D(texture.id(), 0, 0, 0, GLint(level), first.width(), first.height(), 1,
                        GL_RGBA, GL_FLOAT, rgba(levels[level]).data());
  }
  check_gl("uploading a texture array");
  return texture;
}

Image Texture::download() const {
  Image image(width_, height_, 4);
  glGetTextureImage(id(), 0, GL_RGBA, GL_FLOAT, GLsizei(image.values().size_bytes()),
                    image.values().data());
  check_gl("reading a texture back");
  return image;
}

glm::vec4 Texture::texel(int x, int y) const {
  glm::vec4 value;
  glGetTextureSubImage(id(), 0, x, y, 0, 1, 1, 1, GL_RGBA, GL_FLOAT, sizeof(value), &value);
  check_gl("reading a texel back");
  return value;
}

Image Texture::download_layer(int layer) const {
  Image image(width_, height_, 4);
  glGetTextureSubImage(id(), 0, 0, 0, layer, width_, height_, 1, GL_RGBA, GL_FLOAT,
                       GLsizei(image.values().size_bytes()), image.values().data());
  check_gl("reading a layer of a texture back");
  return image;
}

std::vector<std::uint32_t> Texture::download_integers() const {
  std::vector<std::uint32_t> values(std::size_t(width_) * std::size_t(height_) * 4);
  glGetTextureImage(id(), 0, GL_RGBA_INTEGER, GL_UNSIGNED_INT,
                    GLsizei(values.size() * sizeof(std::uint32_t)), values.data());
  check_gl("reading an integer texture back");
  return values;
}

Framebuffer::Framebuffer(int width, int height, std::span<const GLenum> color_formats, bool depth) {
  GLuint id = 0;
  glCreateFramebuffers(1, &id);
  object_ = GlObject<delete_framebuffer>(id);
  for (const GLenum format : color_formats) {
    const auto attachment = GLenum(GL_COLOR_ATTACHMENT0 + colors_.size());
    colors_.emplace_back(width, height, format);
    glNamedFramebufferTexture(id, attachment, colors_.back().id(), 0);
  }
  if (depth) {
    depth_ = Texture(width, height, GL_DEPTH_COMPONENT32F);
    glNamedFramebufferTexture(id, GL_DEPTH_ATTACHMENT, depth_.id(), 0);
  }
  set_draw_buffers(id, colors_.size());
  check_complete(id, width, height);
}

void Framebuffer::bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, object_.id());
  glViewport(0, 0, colors_.front().width(), colors_.front().height());
}

LayerFramebuffer::LayerFramebuffer(std::span<const Texture* const> arrays, int layer,
                                   const Texture* depth)
    : width_(arrays.front()->width()), height_(arrays.front()->height()) {
  GLuint id = 0;
  glCreateFramebuffers(1, &id);
  object_ = GlObject<delete_framebuffer>(id);
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    glNamedFramebufferTextureLayer(id, GLenum(GL_COLOR_ATTACHMENT0 + i), arrays[i]->id(), 0, layer);
  }
  if (depth) glNamedFramebufferTexture(id, GL_DEPTH_ATTACHMENT, depth->id(), 0);
  set_draw_buffers(id, arrays.size());
  check_complete(id, width_, height_);
}

void LayerFramebuffer::bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, object_.id());
  glViewport(0, 0, width_, height_);
}

Buffer::Buffer(const void* data, std::size_t bytes) {
  GLuint id = 0;
  glCreateBuffers(1, &id);
  object_ = GlObject<delete_buffer>(id);
  glNamedBufferStorage(id, GLsizeiptr(bytes), data, 0);
  check_gl("filling a buffer");
}

TexelBuffer::TexelBuffer(GLenum internal_format, const void* data, std::size_t bytes)
    : buffer_(data, bytes) {
  GLuint id = 0;
  glCreateTextures(GL_TEXTURE_BUFFER, 1, &id);
  texture_ = GlObject<delete_texture>(id);
  glTextureBuffer(id, internal_format, buffer_.id());
  check_gl("making a texel buffer");
}

}  // namespace occlab
