// PNG files of any colour type and depth, not compressed.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace occlab::test {

inline std::string big_endian(std::uint32_t value) {
  std::string bytes(4, '\0');
  for (std::size_t i = 0; i < 4; ++i) bytes[i] = char(value >> (24 - 8 * i) & 0xffu);
  return bytes;
}

/// The checksum of PNG's chunks [ISO 3309].
inline std::uint32_t crc32_of(const std::string& bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const char c : bytes) {
    crc ^= std::uint8_t(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1u) ? 0xedb88320u : 0u);
  }
  return ~crc;
}

inline std::string png_chunk(const std::string& type, const std::string& data) {
  return big_endian(std::uint32_t(data.size())) + type + data + big_endian(crc32_of(type + data));
}

/// `samples`: all rows' bytes, the top one first, less than 65 kB; `colour_type` as PNG has it: 0
/// grey, 2 RGB, 4 grey and alpha, 6 RGBA; `bits` a sample, 8 or 16, the more significant byte
/// first.
inline std::string tiny_png(std::uint32_t width, std::uint32_t height, int bits, int colour_type,
                            const std::string& samples) {
  std::string rows;
  for (std::size_t y = 0; y < height; ++y) {
    rows += '\0' + samples.substr(y * samples.size() / height, samples.size() / height);
  }
  std::uint32_t a = 1, b = 0;  // Adler-32
  for (const char c : rows) {
    a = (a + std::uint8_t(c)) % 65521u;
    b = (b + a) % 65521u;
  }
  const auto low_first = [](std::size_t value) {
    return std::string{char(value & 0xffu), char(value >> 8 & 0xffu)};
  };
  const std::string stored = std::string("\x78\x01\x01", 3) + low_first(rows.size()) +
                             low_first(~rows.size()) + rows + big_endian(b << 16 | a);
  const std::string header = big_endian(width) + big_endian(height) + char(bits) +
                             char(colour_type) + std::string(3, '\0');
  return "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", header) + png_chunk("IDAT", stored) +
         png_chunk("IEND", "");
}

}  // namespace occlab::test
