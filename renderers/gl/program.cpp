#include "renderers/gl/program.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/gtc/type_ptr.hpp>

#include "renderers/gl/context.h"
#include "renderers/gl/gbuffer.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

void delete_shader(GLuint id) { glDeleteShader(id); }
using Shader = GlObject<delete_shader>;

std::string shader_log(GLuint id) {
  GLint length = 0;
  glGetShaderiv(id, GL_INFO_LOG_LENGTH, &length);
  std::string log(std::size_t(length) + 1, '\0');
  GLsizei written = 0;
  glGetShaderInfoLog(id, length + 1, &written, log.data());
  log.resize(std::size_t(written));
  return log;
}

Shader compile(GLenum stage, const ShaderSource& source) {
  Shader shader(glCreateShader(stage));
  const char* text = source.text.c_str();
  glShaderSource(shader.id(), 1, &text, nullptr);
  glCompileShader(shader.id());
  GLint compiled = 0;
  glGetShaderiv(shader.id(), GL_COMPILE_STATUS, &compiled);
  if (!compiled) {
    throw DeviceError(fmt::format("{} does not compile:\n{}", source.files.front(),
                                  locate_messages(shader_log(shader.id()), source.files)));
  }
  return shader;
}

}  // namespace

void delete_program(GLuint id) { glDeleteProgram(id); }

Program::Program(std::string_view vertex_path, std::string_view fragment_path,
                 std::string_view preamble)
    : Program(expand_shader(vertex_path, preamble), expand_shader(fragment_path, preamble)) {}

Program::Program(const ShaderSource& vertex, const ShaderSource& fragment)
    : object_(glCreateProgram()) {
  const Shader vertex_shader = compile(GL_VERTEX_SHADER, vertex);
  const Shader fragment_shader = compile(GL_FRAGMENT_SHADER, fragment);
  glAttachShader(object_.id(), vertex_shader.id());
  glAttachShader(object_.id(), fragment_shader.id());
  glLinkProgram(object_.id());
  // Attached, they would live as long as the program.
  glDetachShader(object_.id(), vertex_shader.id());
  glDetachShader(object_.id(), fragment_shader.id());
  GLint linked = 0;
  glGetProgramiv(object_.id(), GL_LINK_STATUS, &linked);
  if (!linked) {
    std::string log(4096, '\0');
    glGetProgramInfoLog(object_.id(), GLsizei(log.size()), nullptr, log.data());
    throw DeviceError(fmt::format("{} with {} does not link:\n{}", vertex.files.front(),
                                  fragment.files.front(), log.c_str()));
  }
}

GLint Program::location(const char* name) const { return glGetUniformLocation(object_.id(), name); }

void Program::set(const char* name, float value) const {
  glProgramUniform1f(object_.id(), location(name), value);
}
void Program::set(const char* name, int value) const {
  glProgramUniform1i(object_.id(), location(name), value);
}
void Program::set(const char* name, glm::vec2 value) const {
  glProgramUniform2fv(object_.id(), location(name), 1, glm::value_ptr(value));
}
void Program::set(const char* name, glm::vec3 value) const {
  glProgramUniform3fv(object_.id(), location(name), 1, glm::value_ptr(value));
}
void Program::set(const char* name, const glm::mat3& value) const {
  glProgramUniformMatrix3fv(object_.id(), location(name), 1, GL_FALSE, glm::value_ptr(value));
}
void Program::set(const char* name, const glm::mat4& value) const {
  glProgramUniformMatrix4fv(object_.id(), location(name), 1, GL_FALSE, glm::value_ptr(value));
}

void Program::bind_texture(GLuint unit, const Texture& texture) {
  glBindTextureUnit(unit, texture.id());
}

void Program::bind_texels(GLuint unit, const TexelBuffer& texels) {
  glBindTextureUnit(unit, texels.id());
}

void Program::bind_uniform_buffer(GLuint binding, const Buffer& buffer) {
  glBindBufferBase(GL_UNIFORM_BUFFER, binding, buffer.id());
}

const Program& ProgramCache::get(std::string_view vertex_path, std::string_view fragment_path,
                                 const std::string& preamble) {
  const std::string key = fmt::format("{}\n{}\n{}", vertex_path, fragment_path, preamble);
  ++uses_;
  if (const auto found = programs_.find(key); found != programs_.end()) {
    found->second.last_use = uses_;
    return found->second.program;
  }
  if (programs_.size() == most) drop_the_longest_unused();
  Entry entry{Program(vertex_path, fragment_path, preamble), uses_};
  return programs_.emplace(key, std::move(entry)).first->second.program;
}

void ProgramCache::drop_the_longest_unused() {
  programs_.erase(std::ranges::min_element(
      programs_, {}, [](const auto& named) { return named.second.last_use; }));
}

namespace {

void draw_triangle() {
  // Core profile wants a vertex array even for a triangle that has no attributes.
  GLuint id = 0;
  glCreateVertexArrays(1, &id);
  const GlObject<delete_vertex_array> vertex_array(id);
  glBindVertexArray(id);
  glDisable(GL_DEPTH_TEST);
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace

void draw_fullscreen() {
  glDisable(GL_BLEND);
  draw_triangle();
}

void add_fullscreen() {
  glEnable(GL_BLEND);
  glBlendEquation(GL_FUNC_ADD);
  glBlendFunc(GL_ONE, GL_ONE);
  draw_triangle();
  glDisable(GL_BLEND);
}

}  // namespace occlab
