# cmake -DOUTPUT=FILE -DROOT=DIR "-DFILES=a;b" -P embed.cmake
# Writes a C++ file that defines occlab::embedded_shaders() with the texts of FILES (paths below ROOT).
set(entries "")
foreach(file IN LISTS FILES)
  file(READ "${ROOT}/${file}" text)
  string(APPEND entries "    {\"${file}\", R\"embedded(${text})embedded\"},\n")
endforeach()
file(WRITE "${OUTPUT}.new" "#include \"renderers/gl/embedded_shaders.h\"

#include <array>

namespace occlab {

std::span<const EmbeddedShader> embedded_shaders() {
  static constexpr auto shaders = std::to_array<EmbeddedShader>({
${entries}  });
  return shaders;
}

}  // namespace occlab
")
file(COPY_FILE "${OUTPUT}.new" "${OUTPUT}" ONLY_IF_DIFFERENT)
