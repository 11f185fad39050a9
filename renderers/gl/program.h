#pragma once

#include <epoxy/gl.h>

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "renderers/gl/texture.h"

namespace occlab {

/// A file of the shader sources that were embedded at build time, by its path in the repository
/// ("renderers/methods/ssao.frag"). Throws InputError if there is none.
std::string_view shader_file(std::string_view path);

/// GLSL with its includes in place, each file once. `#line` keeps the compiler's messages on the
/// original file and line.
struct ShaderSource {
  std::string text;
  std::vector<std::string> files;  ///< by the number that messages give them
};

/// Puts `#version`, `preamble` and the file's expanded text together. Throws InputError naming
/// file and line of an include that is missing.
ShaderSource expand_shader(std::string_view path, std::string_view preamble);

/// Rewrites "0:12(3): error" style positions to "renderers/methods/ssao.frag:12".
std::string locate_messages(const std::string& log, const std::vector<std::string>& files);

void delete_program(GLuint id);

/// A vertex and a fragment shader, linked.
class Program {
 public:
  /// Throws DeviceError with the compiler's messages on the original files and lines.
  Program(std::string_view vertex_path, std::string_view fragment_path, std::string_view preamble);
  /// The same of sources that are expanded already.
  Program(const ShaderSource& vertex, const ShaderSource& fragment);

  void use() const { glUseProgram(object_.id()); }

  /// Uniforms that the compiler removed are ignored; unknown names are our bug elsewhere.
  void set(const char* name, float value) const;
  void set(const char* name, int value) const;
  void set(const char* name, glm::vec2 value) const;
  void set(const char* name, glm::vec3 value) const;
  void set(const char* name, const glm::mat3& value) const;
  void set(const char* name, const glm::mat4& value) const;
  /// Binds a texture to the unit the shader's layout(binding) names.
  static void bind_texture(GLuint unit, const Texture& texture);
  static void bind_texels(GLuint unit, const TexelBuffer& texels);
  static void bind_uniform_buffer(GLuint binding, const Buffer& buffer);

 private:
  GLint location(const char* name) const;
  GlObject<delete_program> object_;
};

/// Programs by what they were made from, so that a sweep compiles each once: as long as it uses no
/// more than `most` at a time, whatever their number in all.
class ProgramCache {
 public:
  static constexpr std::size_t most = 128;

  /// Good until `most` others were asked for.
  const Program& get(std::string_view vertex_path, std::string_view fragment_path,
                     const std::string& preamble);

 private:
  struct Entry {
    Program program;
    std::uint64_t last_use;
  };
  void drop_the_longest_unused();

  std::map<std::string, Entry> programs_;
  std::uint64_t uses_ = 0;
};

/// Draws one triangle over the whole viewport with the program in use.
void draw_fullscreen();
/// The same, added to what the targets hold.
void add_fullscreen();
inline constexpr std::string_view fullscreen_vertex_shader = "renderers/gl/fullscreen.vert";

}  // namespace occlab
