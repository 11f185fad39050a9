// renderers/shared/half.h against the halves' definition.
#include "renderers/shared/half.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <glm/packing.hpp>
#include <random>

namespace occlab {
namespace {

TEST(Half, IsTheNearest) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> exponent(-13.99f, 15.9f);
  for (int i = 0; i < 100000; ++i) {
    const float a = std::exp2(exponent(random)) * (i % 2 ? 1.0f : -1.0f);
    const float b = std::exp2(exponent(random)) * (i % 3 ? 1.0f : -1.0f);
    const vec2 back = glm::unpackHalf2x16(pack_halves(a, b));
    EXPECT_LE(std::abs(back.x - a), 0x1p-11f * std::abs(a)) << a;
    EXPECT_LE(std::abs(back.y - b), 0x1p-11f * std::abs(b)) << b;
  }
}

TEST(Half, KeepsWhatAHalfHolds) {
  // Every normal half, of either sign, in either place.
  for (std::uint32_t bits = 0x0400; bits < 0x7c00; ++bits) {
    const float value = glm::unpackHalf2x16(bits).x;
    EXPECT_EQ(pack_halves(value, -value), bits | (bits | 0x8000u) << 16);
    EXPECT_EQ(pack_halves(-value, value), (bits | 0x8000u) | bits << 16);
  }
  EXPECT_EQ(pack_halves(0.0f, 0.0f), 0u);
}

TEST(Half, UnpacksWhatAHalfHolds) {
  for (std::uint32_t bits = 0; bits < 0x7c00; ++bits) {
    const std::uint32_t both = bits | ((0x7bffu - bits) | 0x8000u) << 16;
    EXPECT_EQ(unpack_halves(both), glm::unpackHalf2x16(both)) << bits;
  }
}

TEST(Half, NearZeroIsNear) {
  for (int i = 0; i < 600; ++i) {  // down to 1e-12
    const float value = 0x1p-14f * std::pow(0.97f, float(i));
    const vec2 back = glm::unpackHalf2x16(pack_halves(value, -value));
    EXPECT_NEAR(back.x, value, 0x1p-14f);
    EXPECT_NEAR(back.y, -value, 0x1p-14f);
    EXPECT_TRUE(back.x == 0.0f || back.x >= 0x1p-14f) << value;
  }
}

}  // namespace
}  // namespace occlab
