#pragma once

#include <span>
#include <string_view>

namespace occlab {

/// A shader source as it stood in the repository when occlab was built (cmake/embed.cmake).
struct EmbeddedShader {
  std::string_view path;
  std::string_view text;
};

std::span<const EmbeddedShader> embedded_shaders();

}  // namespace occlab
