#pragma once

#include <epoxy/gl.h>

#include <atomic>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <utility>
#include <vector>

#include "renderers/scene/image.h"

namespace occlab {

/// How many objects OpenGL gave us and has not got back, of all kinds: 0 when a context ends.
inline std::atomic<long> live_gl_objects{0};

/// A number OpenGL gave us, deleted with its owner.
template <auto Delete>
class GlObject {
 public:
  GlObject() = default;
  explicit GlObject(GLuint id) : id_(id) { count(1); }
  ~GlObject() {
    if (id_) Delete(id_);
    count(-1);
  }
  GlObject(const GlObject&) = delete;
  GlObject& operator=(const GlObject&) = delete;
  GlObject(GlObject&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  GlObject& operator=(GlObject&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  GLuint id() const { return id_; }
  /// How many of this kind there are.
  static long live() { return live_; }

 private:
  void count(long change) const {
    if (!id_) return;
    live_ += change;
    live_gl_objects += change;
  }
  inline static std::atomic<long> live_{0};
  GLuint id_ = 0;
};

void delete_texture(GLuint id);
void delete_framebuffer(GLuint id);
void delete_buffer(GLuint id);

/// A 2-D texture or 2-D array with one level, nearest filtering and clamped edges unless stated.
/// Texel row 0 is the image's top row throughout occlab.
class Texture {
 public:
  Texture() = default;
  Texture(int width, int height, GLenum internal_format);
  /// A 2-D array of that many layers.
  static Texture array(int width, int height, int layers, GLenum internal_format);

  /// RGBA32F from an image of 1 to 4 channels; missing channels are 0, missing alpha 1.
  static Texture from_image(const Image& image);
  /// An RGBA32F array of equirect images of one size: linear filtering, u wraps, v clamps.
  static Texture from_equirect_levels(std::span<const Image> levels);

  GLuint id() const { return object_.id(); }
  int width() const { return width_; }
  int height() const { return height_; }
  GLenum format() const { return format_; }

  /// Writes a float format's texels from an image of its size, as from_image() takes it.
  void upload(const Image& image) const;
  /// Writes an RGBA32UI texture's texels, 4 values each.
  void upload_integers(const std::uint32_t* values) const;

  /// Reads a float or normalised format back as 4 channels.
  Image download() const;
  /// One texel of the same.
  glm::vec4 texel(int x, int y) const;
  /// The same of one layer of an array.
  Image download_layer(int layer) const;
  /// Reads an RGBA32UI texture back, 4 values a texel.
  std::vector<std::uint32_t> download_integers() const;

 private:
  GlObject<delete_texture> object_;
  int width_ = 0;
  int height_ = 0;
  GLenum format_ = 0;
};

/// Colour targets of one size, and a depth buffer if asked for.
class Framebuffer {
 public:
  Framebuffer(int width, int height, std::span<const GLenum> color_formats, bool depth);

  void bind() const;  ///< and sets the viewport
  const std::vector<Texture>& colors() const { return colors_; }
  const Texture& depth() const { return depth_; }

 private:
  GlObject<delete_framebuffer> object_;
  std::vector<Texture> colors_;
  Texture depth_;
};

/// One layer of texture arrays of one size as colour targets, in their order; `depth` may be null.
/// The textures outlive it.
class LayerFramebuffer {
 public:
  LayerFramebuffer(std::span<const Texture* const> arrays, int layer, const Texture* depth);

  void bind() const;  ///< and sets the viewport

 private:
  GlObject<delete_framebuffer> object_;
  int width_ = 0;
  int height_ = 0;
};

/// A buffer that is written once.
class Buffer {
 public:
  Buffer() = default;
  Buffer(const void* data, std::size_t bytes);
  GLuint id() const { return object_.id(); }

 private:
  GlObject<delete_buffer> object_;
};

/// A row of texels that is written once: a buffer that shaders fetch from by index.
class TexelBuffer {
 public:
  TexelBuffer(GLenum internal_format, const void* data, std::size_t bytes);
  GLuint id() const { return texture_.id(); }

 private:
  Buffer buffer_;
  GlObject<delete_texture> texture_;
};

}  // namespace occlab
