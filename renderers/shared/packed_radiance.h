// Radiance in 64 bits: three floats without a sign, of 8 bits of exponent and 13 of mantissa. Half
// the bytes of what a probe's texels would take otherwise, so that caches hold twice as many.
#pragma once
#include "renderers/shared/glsl.h"

SHARED_BEGIN

// The 21 bits of a value of at least 0: off by at most 2^-14 of itself.
SHARED uint short_float_bits(float value) { return (floatBitsToUint(value) + 0x200u) >> 10; }

// No channel below 0, nor above 2^127.
SHARED uvec2 pack_radiance(vec3 radiance) {
  const uint blue = short_float_bits(radiance.z);
  return uvec2((short_float_bits(radiance.x) << 11) | (blue >> 10),
               (short_float_bits(radiance.y) << 11) | (blue & 0x3ffu));
}

SHARED vec3 unpack_radiance(uvec2 bits) {
  return vec3(uintBitsToFloat((bits.x & 0xfffff800u) >> 1),
              uintBitsToFloat((bits.y & 0xfffff800u) >> 1),
              uintBitsToFloat(((bits.x & 0x7ffu) << 20) | ((bits.y & 0x3ffu) << 10)));
}

SHARED_END
