#pragma once

#include <vector>

#include "renderers/scene/environment.h"
#include "renderers/trace/packet.h"

namespace occlab {

/// shared/trigonometry.h's arctan2, for vectors.
inline Float8 atan2_8(Float8 y, Float8 x) {
  const Float8 ax = abs8(x);
  const Float8 ay = abs8(y);
  const Float8 larger = ax > ay ? ax : ay;
  const Float8 smaller = ax > ay ? ay : ax;
  const Float8 a = smaller / (larger > 0.0f ? larger : all8(1.0f));
  const Float8 s = a * a;
  Float8 p = all8(0.0028662257f);
  p = p * s - 0.0161657367f;
  p = p * s + 0.0429096138f;
  p = p * s - 0.0752896400f;
  p = p * s + 0.1065626393f;
  p = p * s - 0.1420889944f;
  p = p * s + 0.1999355085f;
  p = p * s - 0.3333314528f;
  Float8 angle = a + a * s * p;
  angle = ay > ax ? 1.57079632679f - angle : angle;
  angle = x < 0.0f ? 3.14159265359f - angle : angle;
  return y < 0.0f ? -angle : angle;
}

/// A probe's radiance and the density with which the sampler draws it, one look-up for both.
struct ProbeTable {
  struct alignas(16) Texel {
    float r, g, b;
    float pdf;  ///< per solid angle
  };

  ProbeTable(const Environment& environment, const EnvironmentSampler& sampler);

  /// The texels that eight of the directions meet: shared/equirect.h's equirect_uv() without
  /// branches.
  Int8 index(const Lanes3& direction_world, int half) const {
    const auto& m = probe_from_world;
    const Float8 dx = load8(direction_world.x, half);
    const Float8 dy = load8(direction_world.y, half);
    const Float8 dz = load8(direction_world.z, half);
    const Float8 x = m[0][0] * dx + m[1][0] * dy + m[2][0] * dz;
    const Float8 y = m[0][1] * dx + m[1][1] * dy + m[2][1] * dz;
    const Float8 z = m[0][2] * dx + m[1][2] * dy + m[2][2] * dz;
    const Float8 u = 0.5f + atan2_8(z, x) * 0.1591549431f;
    // Not the arccosine of y, as in shared/equirect.h.
    const Float8 v = atan2_8(sqrt8(x * x + z * z), y) * 0.3183098862f;
    const auto clamped = [](Float8 value, int size) {
      const Int8 i = __builtin_convertvector(value * float(size), Int8);
      const Int8 least = i > 0 ? i : Int8{};
      return least < size ? least : Int8{} + (size - 1);
    };
    return clamped(v, height) * width + clamped(u, width);
  }

  int width;
  int height;
  glm::mat3 probe_from_world;
  std::vector<Texel> texels;
};

}  // namespace occlab
