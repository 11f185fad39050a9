#pragma once

#include <embree3/rtcore.h>
#include <immintrin.h>

#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>

namespace occlab {

/// 16 values, one a pixel of a 4x4 tile; the loops over them are written for the vectoriser.
inline constexpr int lane_count = 16;
struct alignas(64) Lanes {
  std::array<float, lane_count> v{};
  float& operator[](int lane) { return v[std::size_t(lane)]; }
  float operator[](int lane) const { return v[std::size_t(lane)]; }
};
/// Half of the lanes, as a vector of the compiler's.
using Float8 = float __attribute__((vector_size(32)));
using Int8 = int __attribute__((vector_size(32)));
inline constexpr int half_lanes[] = {0, 8};
inline Float8 load8(const Lanes& lanes, int first) {
  return *reinterpret_cast<const Float8*>(&lanes.v[std::size_t(first)]);
}
inline void store8(Lanes& lanes, int first, Float8 value) {
  *reinterpret_cast<Float8*>(&lanes.v[std::size_t(first)]) = value;
}
inline Float8 all8(float x) { return Float8{x, x, x, x, x, x, x, x}; }
inline Float8 abs8(Float8 x) { return x < 0.0f ? -x : x; }
struct Lanes3 {
  Lanes x, y, z;
};
inline glm::vec3 at(const Lanes3& lanes, int lane) {
  return {lanes.x[lane], lanes.y[lane], lanes.z[lane]};
}
inline void set_lane(Lanes3& lanes, int lane, glm::vec3 value) {
  lanes.x[lane] = value.x;
  lanes.y[lane] = value.y;
  lanes.z[lane] = value.z;
}
struct alignas(64) LaneMask {
  std::array<int, lane_count> v{};  ///< -1: active, 0: not, as Embree has it
  int& operator[](int lane) { return v[std::size_t(lane)]; }
  int operator[](int lane) const { return v[std::size_t(lane)]; }
};

/// An orthonormal frame a lane.
struct LaneFrames {
  Lanes3 tangent, bitangent, normal;
};
/// A direction of all the frames, in the space that they are given in. Always inlined, for it to be
/// compiled as its caller is: with fused products or without.
[[gnu::always_inline]] inline Lanes3 out_of(const LaneFrames& frames, glm::vec3 d) {
  Lanes3 result;
  for (const int half : half_lanes) {
    const auto turned = [&](const Lanes& t, const Lanes& b, const Lanes& n) {
      return load8(t, half) * d.x + load8(b, half) * d.y + load8(n, half) * d.z;
    };
    store8(result.x, half, turned(frames.tangent.x, frames.bitangent.x, frames.normal.x));
    store8(result.y, half, turned(frames.tangent.y, frames.bitangent.y, frames.normal.y));
    store8(result.z, half, turned(frames.tangent.z, frames.bitangent.z, frames.normal.z));
  }
  return result;
}

inline Float8 sqrt8(Float8 x) { return _mm256_sqrt_ps(x); }

/// Fills a packet of rays from `origin` along `direction`, from 0 to `distance`.
template <typename Ray>
void fill_rays(Ray& ray, const Lanes3& origin, const Lanes3& direction, const Lanes& distance) {
  for (int i = 0; i < lane_count; ++i) {
    ray.org_x[i] = origin.x[i];
    ray.org_y[i] = origin.y[i];
    ray.org_z[i] = origin.z[i];
    ray.dir_x[i] = direction.x[i];
    ray.dir_y[i] = direction.y[i];
    ray.dir_z[i] = direction.z[i];
    ray.tnear[i] = 0.0f;
    ray.tfar[i] = distance[i];
    ray.time[i] = 0.0f;
    ray.mask[i] = ~0u;
    ray.id[i] = 0;
    ray.flags[i] = 0;
  }
}

}  // namespace occlab
