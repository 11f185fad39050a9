#include "renderers/methods/representation_layers.h"

#include <array>

#include "renderers/shared/representation_sh4.h"

namespace occlab {
namespace {

uvec4 texel(const std::vector<std::uint32_t>& values, std::size_t index) {
  const std::uint32_t* v = &values[index * 4];
  return uvec4(v[0], v[1], v[2], v[3]);
}

}  // namespace

Image channels_of(const Image& image, int first, int count) {
  Image part(image.width(), image.height(), count);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int c = 0; c < count; ++c) part.at(x, y, c) = image.at(x, y, first + c);
    }
  }
  return part;
}

Image unpack_sh(const Texture& low, const Texture& high) {
  const std::vector<std::uint32_t> low_bits = low.download_integers();
  const std::vector<std::uint32_t> high_bits = high.download_integers();
  Image coefficients(low.width(), low.height(), 16);
  for (std::size_t p = 0; p < coefficients.pixel_count(); ++p) {
    const Sh4 sh = sh_unpack(texel(low_bits, p), texel(high_bits, p));
    const std::array<vec4, 4> parts = {sh.c0, sh.c1, sh.c2, sh.c3};
    for (std::size_t i = 0; i < 16; ++i) {
      coefficients.values()[p * 16 + i] = parts[i / 4][int(i % 4)];
    }
  }
  return coefficients;
}

Image sh_ambient_occlusion(const Image& coefficients) {
  Image occlusion = channels_of(coefficients, 0, 1);
  for (float& value : occlusion.values()) {
    value = sh4_ambient_occlusion(sh4(vec4(value, 0, 0, 0), vec4(0), vec4(0), vec4(0)));
  }
  return occlusion;
}

}  // namespace occlab
