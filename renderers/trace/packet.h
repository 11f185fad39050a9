#pragma once

#include <embree3/rtcore.h>

#include <array>
#include <cmath>
#include <limits>

namespace occlab {

/// 16 values, one a pixel of a 4x4 tile; the loops over them are written for the vectoriser.
inline constexpr int lane_count = 16;
struct alignas(64) Lanes {
  std::array<float, lane_count> v{};
  float& operator[](int lane) { return v[std::size_t(lane)]; }
  float operator[](int lane) const { return v[std::size_t(lane)]; }
};
struct Lanes3 {
  Lanes x, y, z;
};
struct alignas(64) LaneMask {
  std::array<int, lane_count> v{};  ///< -1: active, 0: not, as Embree has it
  int& operator[](int lane) { return v[std::size_t(lane)]; }
  int operator[](int lane) const { return v[std::size_t(lane)]; }
};

/// arctan2 to 1e-7 rad, without branches [Abramowitz and Stegun 4.4.49].
inline float lane_atan2(float y, float x) {
  const float ax = std::fabs(x);
  const float ay = std::fabs(y);
  const float larger = ax > ay ? ax : ay;
  const float smaller = ax > ay ? ay : ax;
  const float a = smaller / (larger > 0.0f ? larger : 1.0f);
  const float s = a * a;
  float p = 0.0028662257f;
  p = p * s - 0.0161657367f;
  p = p * s + 0.0429096138f;
  p = p * s - 0.0752896400f;
  p = p * s + 0.1065626393f;
  p = p * s - 0.1420889944f;
  p = p * s + 0.1999355085f;
  p = p * s - 0.3333314528f;
  float angle = a + a * s * p;
  angle = ay > ax ? 1.57079632679f - angle : angle;
  angle = x < 0.0f ? 3.14159265359f - angle : angle;
  return y < 0.0f ? -angle : angle;
}

/// arccos to 1e-7 rad for x in [-1, 1], without branches [Abramowitz and Stegun 4.4.46].
inline float lane_acos(float x) {
  const float a = std::fabs(x);
  float p = -0.0012624911f;
  p = p * a + 0.0066700901f;
  p = p * a - 0.0170881256f;
  p = p * a + 0.0308918810f;
  p = p * a - 0.0501743046f;
  p = p * a + 0.0889789874f;
  p = p * a - 0.2145988016f;
  p = p * a + 1.5707963050f;
  const float angle = std::sqrt(1.0f - (a < 1.0f ? a : 1.0f)) * p;
  return x < 0.0f ? 3.14159265359f - angle : angle;
}

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
