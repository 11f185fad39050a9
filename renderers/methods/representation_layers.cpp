#include "renderers/methods/representation_layers.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "renderers/shared/representation_sh4.h"

namespace occlab {
namespace {

uvec4 texel(const std::vector<std::uint32_t>& values, std::size_t index) {
  const std::uint32_t* v = &values[index * 4];
  return uvec4(v[0], v[1], v[2], v[3]);
}

}  // namespace

Sh4 sh_of(const Representation::Values& v) {
  return sh4(vec4(v[0], v[1], v[2], v[3]), vec4(v[4], v[5], v[6], v[7]),
             vec4(v[8], v[9], v[10], v[11]), vec4(v[12], v[13], v[14], v[15]));
}

Representation::Values values_of(const Sh4& sh) {
  Representation::Values values;
  const std::array<vec4, 4> parts = {sh.c0, sh.c1, sh.c2, sh.c3};
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = parts[i / 4][int(i % 4)];
  return values;
}

Image channels_of(const Image& image, int first, int count) {
  Image part(image.width(), image.height(), count);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int c = 0; c < count; ++c) part.at(x, y, c) = image.at(x, y, first + c);
    }
  }
  return part;
}

Image sum_of(Image a, const Image& b) {
  assert(a.values().size() == b.values().size());
  for (std::size_t i = 0; i < a.values().size(); ++i) a.values()[i] += b.values()[i];
  return a;
}

Image difference(Image a, const Image& b) {
  assert(a.values().size() == b.values().size());
  for (std::size_t i = 0; i < a.values().size(); ++i) a.values()[i] -= b.values()[i];
  return a;
}

Image download_packed_sh(const Framebuffer& target, int) {
  const Texture& low = target.colors()[0];
  const Texture& high = target.colors()[1];
  const std::vector<std::uint32_t> low_bits = low.download_integers();
  const std::vector<std::uint32_t> high_bits = high.download_integers();
  Image coefficients(low.width(), low.height(), 16);
  for (std::size_t p = 0; p < coefficients.pixel_count(); ++p) {
    const auto values = values_of(sh_unpack(texel(low_bits, p), texel(high_bits, p)));
    std::ranges::copy(values, &coefficients.values()[p * 16]);
  }
  return coefficients;
}

void upload_packed_sh(const Image& coefficients, const Framebuffer& target) {
  std::vector<uvec4> low;
  std::vector<uvec4> high;
  for (std::size_t p = 0; p < coefficients.pixel_count(); ++p) {
    Representation::Values values;
    std::copy_n(&coefficients.values()[p * 16], values.size(), values.begin());
    const auto sh = sh_of(values);
    low.push_back(sh_pack_low(sh));
    high.push_back(sh_pack_high(sh));
  }
  target.colors()[0].upload_integers(&low[0][0]);
  target.colors()[1].upload_integers(&high[0][0]);
}

void upload_floats(const Image& values, const Framebuffer& target) {
  target.colors()[0].upload(values);
}

Image download_floats(const Framebuffer& target, int channels) {
  return channels_of(target.colors()[0].download(), 0, channels);
}

Image clamp_negative(Image radiance, std::size_t& negative_pixels) {
  for (std::size_t p = 0; p < radiance.pixel_count(); ++p) {
    bool negative = false;
    for (float& value : radiance.values().subspan(p * 3, 3)) {
      negative |= value < 0.0f;
      value = value < 0.0f ? 0.0f : value;  // a NaN stays one
    }
    negative_pixels += negative ? 1 : 0;
  }
  return radiance;
}

Image sh_ambient_occlusion(const Image& coefficients) {
  Image occlusion = channels_of(coefficients, 0, 1);
  for (float& value : occlusion.values()) {
    value = sh4_ambient_occlusion(sh4(vec4(value, 0, 0, 0), vec4(0), vec4(0), vec4(0)));
  }
  return occlusion;
}

}  // namespace occlab
