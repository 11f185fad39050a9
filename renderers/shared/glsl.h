// What lets the headers of this folder be C++ (through GLM) and GLSL 4.50 alike. Rules for them:
// float literals carry an f, no references but INOUT(type), no recursion. PRECISE values are
// computed as written: GLSL's compilers may regroup products otherwise, and decisions then differ.
#pragma once

#ifdef __cplusplus
#include <glm/glm.hpp>
#define SHARED inline
#define INOUT(type) type&
#define PRECISE const
#define SHARED_BEGIN namespace occlab {
#define SHARED_END }

namespace occlab {
using glm::abs;
using glm::acos;
using glm::asin;
using glm::atan;
using glm::clamp;
using glm::cos;
using glm::cross;
using glm::dot;
using glm::floatBitsToUint;
using glm::floor;
using glm::fract;
using glm::ivec2;
using glm::length;
using glm::mat3;
using glm::max;
using glm::min;
using glm::mix;
using glm::normalize;
using glm::pow;
using glm::sin;
using glm::smoothstep;
using glm::sqrt;
using glm::uint;
using glm::uintBitsToFloat;
using glm::uvec2;
using glm::uvec4;
using glm::vec2;
using glm::vec3;
using glm::vec4;
}  // namespace occlab
#else
#define SHARED
#define INOUT(type) inout type
#define PRECISE precise
#define SHARED_BEGIN
#define SHARED_END
#endif

SHARED_BEGIN
const float pi = 3.14159265358979f;
SHARED_END
