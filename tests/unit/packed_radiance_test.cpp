// renderers/shared/packed_radiance.h against its definition.
#include "renderers/shared/packed_radiance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace occlab {
namespace {

TEST(PackedRadiance, IsWithin13BitsOfMantissa) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> exponent(-40.0f, 60.0f);
  const auto value = [&] { return std::exp2(exponent(random)); };
  for (int i = 0; i < 100000; ++i) {
    const vec3 radiance(value(), value(), value());
    const vec3 back = unpack_radiance(pack_radiance(radiance));
    for (int c = 0; c < 3; ++c) {
      EXPECT_LE(std::abs(back[c] - radiance[c]), 0x1p-14f * radiance[c]) << radiance[c];
    }
    EXPECT_EQ(unpack_radiance(pack_radiance(back)), back);  // what it holds, it keeps
  }
}

TEST(PackedRadiance, ChannelsAreApart) {
  const float large = 0x1.fffp120f;  // every bit of the mantissa
  for (int c = 0; c < 3; ++c) {
    vec3 radiance(0.0f);
    radiance[c] = large;
    EXPECT_EQ(unpack_radiance(pack_radiance(radiance)), radiance);
  }
}

}  // namespace
}  // namespace occlab
