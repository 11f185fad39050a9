#include <fmt/format.h>

#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <limits>

#include "renderers/scene/gltf_parts.h"

namespace occlab {

glm::dmat4 local_transform(const JsonValue& node) {
  if (const auto matrix = node.find("matrix")) {
    const std::vector<double> m = matrix->numbers(16);
    glm::dmat4 result;
    for (int i = 0; i < 16; ++i) result[i / 4][i % 4] = m[std::size_t(i)];
    if (result[0][3] != 0.0 || result[1][3] != 0.0 || result[2][3] != 0.0 || result[3][3] != 1.0) {
      matrix->fail("the last row must be 0, 0, 0, 1");
    }
    return result;
  }
  std::vector<double> translation{0.0, 0.0, 0.0};
  std::vector<double> rotation{0.0, 0.0, 0.0, 1.0};
  std::vector<double> scale{1.0, 1.0, 1.0};
  if (const auto found = node.find("translation")) translation = found->numbers(3);
  if (const auto found = node.find("scale")) scale = found->numbers(3);
  if (const auto found = node.find("rotation")) {
    rotation = found->numbers(4);
    const double norm =
        std::hypot(std::hypot(rotation[0], rotation[1]), std::hypot(rotation[2], rotation[3]));
    if (!(std::abs(norm - 1.0) < 1e-2)) {
      found->fail(fmt::format("found a quaternion of length {:g}; accepted: a unit one", norm));
    }
  }
  const glm::dquat q =
      glm::normalize(glm::dquat(rotation[3], rotation[0], rotation[1], rotation[2]));
  glm::dmat4 result = glm::mat4_cast(q);
  for (int i = 0; i < 3; ++i) result[i] *= scale[std::size_t(i)];
  result[3] = glm::dvec4(translation[0], translation[1], translation[2], 1.0);
  return result;
}

void require_float_range(const JsonValue& node, const glm::dmat4& world) {
  for (int i = 0; i < 16; ++i) {
    if (std::abs(world[i / 4][i % 4]) <= double(std::numeric_limits<float>::max())) continue;
    node.fail("its place or scale in the world is beyond the range of float");
  }
}

bool is_invertible(const glm::mat3& matrix) {
  if (!(std::abs(glm::determinant(matrix)) > 0.0f)) return false;
  const glm::mat3 inverse = glm::inverse(matrix);
  for (int i = 0; i < 9; ++i) {
    if (!std::isfinite(inverse[i / 3][i % 3])) return false;
  }
  return true;
}

glm::dmat4 camera_transform(const JsonValue& node, const glm::dmat4& world) {
  const glm::dvec3 back = world[2];
  const glm::dvec3 right = world[0];
  const glm::dvec3 up = world[1];
  if (!(glm::dot(glm::cross(right, up), back) > 0.0)) {
    node.fail("the camera's transform is singular or mirrored");
  }
  const glm::dvec3 z = glm::normalize(back);
  const glm::dvec3 x = glm::normalize(right - glm::dot(right, z) * z);
  return {glm::dvec4(x, 0.0), glm::dvec4(glm::cross(z, x), 0.0), glm::dvec4(z, 0.0), world[3]};
}

}  // namespace occlab
