// Half floats [IEEE 754 binary16], the same on every device: GLSL's packHalf2x16 may round as the
// device likes, and Mesa's software rasteriser, which truncates, takes longer over it.
#pragma once
#include "renderers/shared/glsl.h"

SHARED_BEGIN

// a in the low half and b in the high one, rounded to nearest: each is off by at most 2^-11 of
// itself. What is smaller than 2^-14 becomes 0: halves have no exponent left there, and devices
// that flush denormals would not read them back. Magnitudes below 65520.
SHARED uint pack_halves(float a, float b) {
  const uint low = floatBitsToUint(a);
  const uint high = floatBitsToUint(b);
  // The exponent's bias goes from 127 to 15, the mantissa from 23 to 10 bits.
  const int rebias = 0x1000 - (112 << 23);
  const int least = 1 << 23;
  const int low_magnitude = int(low & 0x7fffffffu) + rebias;
  const int high_magnitude = int(high & 0x7fffffffu) + rebias;
  return (low_magnitude >= least ? uint(low_magnitude) >> 13 : 0u) | ((low >> 16) & 0x8000u) |
         (high_magnitude >= least ? (uint(high_magnitude) << 3) & 0x7fff0000u : 0u) |
         (high & 0x80000000u);
}

// The values of the low and the high half, as pack_halves() writes them: no infinities, no
// denormals. Mesa's unpackHalf2x16 takes twice as long.
SHARED vec2 unpack_halves(uint halves) {
  const float rebias = 5.192296858534828e33f;  // 2^112
  return rebias * vec2(uintBitsToFloat(((halves & 0x7fffu) << 13) | ((halves & 0x8000u) << 16)),
                       uintBitsToFloat(((halves >> 3) & 0x0fffe000u) | (halves & 0x80000000u)));
}

SHARED_END
