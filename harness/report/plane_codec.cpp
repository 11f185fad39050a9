#include "harness/report/plane_codec.h"

#include <fmt/format.h>
#include <immintrin.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>

#include "renderers/scene/error.h"

namespace occlab::report {
namespace {

using Plane = std::vector<std::uint16_t>;

/// Where a value is guessed from: the neighbours `distance` to the left and above. Those 4 away
/// share the samples of the methods' 4x4 interleaved pattern.
struct Predictor {
  bool gradient;  ///< left + above - the one above left, between the two; else left
  int distance;
};
/// Their numbers are part of the format.
constexpr std::array<Predictor, 4> predictors = {{{false, 1}, {true, 1}, {false, 4}, {true, 4}}};

std::uint16_t rising(std::uint16_t half) {
  return half & 0x8000 ? std::uint16_t(0xffff - half) : std::uint16_t(half + 0x8000);
}

std::vector<Plane> planes_of(const Image& image) {
  const auto channels = std::size_t(image.channels());
  std::vector<Plane> planes(channels, Plane(image.pixel_count()));
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    for (std::size_t c = 0; c < channels; ++c) {
      planes[c][i] = rising(half_bits(image.values()[channels * i + c]));
    }
  }
  if (channels == 3) {
    for (std::size_t i = 0; i < image.pixel_count(); ++i) {
      planes[0][i] = std::uint16_t(planes[0][i] - planes[1][i]);
      planes[2][i] = std::uint16_t(planes[2][i] - planes[1][i]);
    }
    std::swap(planes[0], planes[1]);
  }
  return planes;
}

/// Neighbours outside of the plane are 0.
std::uint16_t predict(const Plane& plane, int width, int x, int y, Predictor predictor) {
  const int d = predictor.distance;
  const auto at = [&](int column, int row) -> int {
    return column < 0 || row < 0
               ? 0
               : plane[std::size_t(row) * std::size_t(width) + std::size_t(column)];
  };
  const int left = at(x - d, y);
  if (!predictor.gradient) return std::uint16_t(left);
  const int above = at(x, y - d);
  const int sloped = left + above - at(x - d, y - d);
  return std::uint16_t(std::clamp(sloped, std::min(left, above), std::max(left, above)));
}

Plane residuals(const Plane& plane, int width, Predictor predictor) {
  Plane result(plane.size());
  for (std::size_t i = 0; i < plane.size(); ++i) {
    const int x = int(i % std::size_t(width));
    const int y = int(i / std::size_t(width));
    const auto r = std::int16_t(std::uint16_t(plane[i] - predict(plane, width, x, y, predictor)));
    result[i] = std::uint16_t(r < 0 ? -2 * (r + 1) + 1 : 2 * r);
  }
  return result;
}

/// About the bits that they take.
std::size_t size_estimate(const Plane& residuals) {
  std::size_t bits = 0;
  for (const std::uint16_t r : residuals) bits += std::size_t(std::bit_width(r));
  return bits;
}

void append_plane(std::vector<std::uint8_t>& stream, const Plane& plane, int width) {
  std::array<Plane, predictors.size()> candidates;
  std::array<std::size_t, predictors.size()> sizes{};
  for (std::size_t p = 0; p < predictors.size(); ++p) {
    candidates[p] = residuals(plane, width, predictors[p]);
    sizes[p] = size_estimate(candidates[p]);
  }
  const auto best = std::size_t(std::ranges::min_element(sizes) - sizes.begin());
  stream.push_back(std::uint8_t(best));
  for (const std::uint16_t r : candidates[best]) stream.push_back(std::uint8_t(r >> 8));
  for (const std::uint16_t r : candidates[best]) stream.push_back(std::uint8_t(r & 0xff));
}

void append_utf16(std::string& text, unsigned code) {
  text += char(code & 0xff);
  text += char(code >> 8);
}

void append_ascii(std::string& text, const std::string& ascii) {
  for (const char c : ascii) append_utf16(text, static_cast<unsigned char>(c));
}

}  // namespace

std::uint16_t half_bits(float value) {
  return std::uint16_t(
      _mm_extract_epi16(_mm_cvtps_ph(_mm_set_ss(value), _MM_FROUND_TO_NEAREST_INT), 0));
}

Image decimate(const Image& image, int step) {
  assert(step >= 1);
  if (step == 1) return image;
  Image result((image.width() + step - 1) / step, (image.height() + step - 1) / step,
               image.channels());
  for (int y = 0; y < result.height(); ++y) {
    for (int x = 0; x < result.width(); ++x) {
      std::ranges::copy(image.pixel(x * step, y * step), result.pixel(x, y).begin());
    }
  }
  return result;
}

std::vector<std::uint8_t> encode_layer(const Image& image) {
  std::vector<std::uint8_t> stream;
  for (const Plane& plane : planes_of(image)) append_plane(stream, plane, image.width());
  std::vector<std::uint8_t> packed(compressBound(stream.size()));
  uLongf size = packed.size();
  if (compress2(packed.data(), &size, stream.data(), stream.size(), Z_BEST_COMPRESSION) != Z_OK) {
    throw DeviceError("zlib cannot compress: out of memory");
  }
  packed.resize(size);
  return packed;
}

std::string layer_script(const std::string& id, const std::vector<std::uint8_t>& bytes) {
  constexpr unsigned first_code = 0x100;
  std::string text = "\xff\xfe";
  text.reserve(bytes.size() * 32 / 15 + 100);
  append_ascii(text, fmt::format("occlabLayer(\"{}\",{},\"", id, bytes.size()));
  std::uint32_t bits = 0;
  int count = 0;
  for (const std::uint8_t byte : bytes) {
    bits |= std::uint32_t(byte) << count;
    count += 8;
    if (count < 15) continue;
    append_utf16(text, first_code + (bits & 0x7fff));
    bits >>= 15;
    count -= 15;
  }
  if (count > 0) append_utf16(text, first_code + bits);
  append_ascii(text, "\");\n");
  return text;
}

}  // namespace occlab::report
