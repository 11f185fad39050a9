#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderers/scene/image.h"

namespace occlab::report {

// How the page gets its pixels. A page opened from disk may read no files, but it may run scripts:
// a layer is a script of one call, occlabLayer("ID", SIZE, "TEXT"), and TEXT holds SIZE bytes:
//
//   1. halves, nearest to the floats, as integers that rise with the value: sign and magnitude
//      become b + 0x8000 for positive and 0xffff - b for negative numbers;
//   2. of three channels, the planes G, R - G and B - G (mod 2^16);
//   3. a plane a time: one byte that names the predictor, the high bytes of all residuals, the low
//      bytes. A residual r (mod 2^16, from -2^15) is stored as 2r or -2r - 1;
//   4. all planes together deflated (zlib, whose checksum finds a damaged file);
//   5. 15 bits a character, low bits first, as code points from 0x100 on: in UTF-16, none of them a
//      quote, a line end or a surrogate.

/// The half nearest to `value` (ties to even), as bits; beyond 65504 an infinity.
std::uint16_t half_bits(float value);

/// Every `step`-th column and row of an image, from the first on.
Image decimate(const Image& image, int step);

/// Steps 1 to 4.
std::vector<std::uint8_t> encode_layer(const Image& image);

/// Step 5 and the call around it, UTF-16LE with its byte order mark.
std::string layer_script(const std::string& id, const std::vector<std::uint8_t>& bytes);

}  // namespace occlab::report
