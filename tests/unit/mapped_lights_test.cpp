// Lights with maps, as far as they are made on the CPU: what stands for an environment, and the
// directions that maps cover.

#include "renderers/methods/mapped_lights.h"

#include <gtest/gtest.h>

#include <array>

#include "renderers/shared/shadow_map.h"
#include "tests/analytic/built_scenes.h"

namespace occlab::test {
namespace {

TEST(EnvironmentLights, CarryTheProbesLight) {
  // Every light has the same mean over colours, so that their sum is the probe's exactly; what
  // arrives on a surface depends on the directions drawn. Over 64 seeds the mean of 256 lights'
  // irradiance has a standard error that the seeds tell; each of 3 normals and 3 colours is within
  // 5 of them: with 63 degrees of freedom and 9 tests the false alarm rate is below 1e-4.
  const Environment sky = probe_of(64, [](glm::vec3 d) {
    return glm::vec3(1.2f + d.x, 1.0f + (d.y > 0.9f ? 30.0f : 0.0f), 1.1f - 0.5f * d.y);
  });
  const SceneSphere sphere{glm::vec3(0.0f), 1.0f};
  const std::array<glm::vec3, 3> normals = {glm::vec3(0, 1, 0), glm::vec3(1, 0, 0),
                                            glm::normalize(glm::vec3(-1, 1, 2))};
  constexpr int seeds = 64;
  for (const glm::vec3& n : normals) {
    glm::dvec3 expected(0.0);
    for (int y = 0; y < sky.texels.height(); ++y) {
      for (int x = 0; x < sky.texels.width(); ++x) {
        // A texel is 1/400 of the sphere: its cosine is taken at 4x4 points.
        for (int i = 0; i < 16; ++i) {
          const glm::vec2 uv((float(x) + (float(i % 4) + 0.5f) / 4) / 64.0f,
                             (float(y) + (0.25f * float(i - i % 4) + 0.5f) / 4) / 32.0f);
          const double cosine = std::max(0.0, double(glm::dot(n, equirect_direction(uv))));
          for (int c = 0; c < 3; ++c) {
            expected[c] +=
                double(sky.texels.at(x, y, c)) * cosine * texel_solid_angle(sky.texels, y) / 16.0;
          }
        }
      }
    }
    glm::dvec3 sum(0.0), squares(0.0);
    for (int seed = 0; seed < seeds; ++seed) {
      glm::dvec3 E(0.0);
      double total = 0.0;
      for (const MappedLight& light : environment_lights(sky, 256, std::uint64_t(seed), sphere)) {
        const glm::dvec3 arriving(glm::vec3(light.light.intensity_and_inner));
        const glm::dvec3 travel(glm::vec3(light.light.direction_and_outer));
        E += arriving * std::max(0.0, -glm::dot(travel, glm::dvec3(n)));
        total += (arriving.x + arriving.y + arriving.z) / 3.0;
      }
      double of_probe = 0.0;
      for (int y = 0; y < sky.texels.height(); ++y) {
        for (int x = 0; x < sky.texels.width(); ++x) {
          const auto texel = sky.texels.pixel(x, y);
          of_probe +=
              double(texel[0] + texel[1] + texel[2]) / 3.0 * texel_solid_angle(sky.texels, y);
        }
      }
      EXPECT_NEAR(total, of_probe, 1e-4 * of_probe);
      sum += E;
      squares += E * E;
    }
    for (int c = 0; c < 3; ++c) {
      const double mean = sum[c] / seeds;
      const double variance = (squares[c] - seeds * mean * mean) / (seeds - 1);
      EXPECT_NEAR(mean, expected[c], 5.0 * std::sqrt(variance / seeds)) << c;
      EXPECT_LT(std::sqrt(variance), 0.05 * expected[c]) << "one seed's 256 lights";
    }
  }
}

TEST(LightProjections, CoverTheirDirections) {
  // Every direction that a projection is for falls into the square of the face that looks its way.
  for (int i = 0; i < 2000; ++i) {
    const float z = 1.0f - 2.0f * (float(i) + 0.5f) / 2000.0f;
    const float r = std::sqrt(1.0f - z * z), phi = 2.3999632f * float(i);
    const glm::vec3 d(r * std::cos(phi), r * std::sin(phi), z);
    const glm::vec3 axis = glm::normalize(glm::vec3(0.3f, -0.8f, 0.4f));
    for (const LightProjection& projection :
         {cube_projection({1, 2, 3}, 0.1f), half_space_projection({1, 2, 3}, axis, 0.1f),
          cone_projection({1, 2, 3}, axis, 0.9f, 0.1f)}) {
      const double cosine = double(glm::dot(d, axis));
      if (projection.faces() == 3 && cosine < 1e-4) continue;
      if (projection.faces() == 1 && cosine < std::cos(0.9) + 1e-4) continue;
      const glm::vec3 q(projection.light_from_world *
                        glm::vec4(glm::vec3(1, 2, 3) + 2.0f * d, 1.0f));
      EXPECT_NEAR(glm::length(q), 2.0f, 1e-5f);
      glm::vec3 best(0, 0, 1e30f);
      for (const glm::mat3& face : projection.face_from_light) {
        EXPECT_NEAR(glm::determinant(face), 1.0f, 1e-5f);
        if ((face * q).z < best.z) best = face * q;
      }
      ASSERT_LT(best.z, 0.0f);
      for (int c = 0; c < 2; ++c) {
        EXPECT_GE(best[c] / -best.z, projection.low - 1e-4f);
        EXPECT_LE(best[c] / -best.z, projection.high + 1e-4f);
      }
    }
  }
}

TEST(EnvironmentLights, OfABlackProbeAreNone) {
  EXPECT_TRUE(environment_lights(constant_environment(glm::vec3(0.0f)), 8, 0, {{}, 1.0f}).empty());
}

TEST(MappedLights, HaveTheMapsOfTheirKind) {
  const SceneSphere sphere{{1, 2, 3}, 5.0f};
  Light light{.name = "light", .position_world = {1, 1, 1}, .intensity = glm::vec3(1.0f)};
  const auto projection = [&] {
    return mapped_lights(std::array{light}, sphere).front().projection;
  };
  EXPECT_EQ(projection().faces(), 6);
  light.type = LightType::spot;
  light.outer_cone_angle = 0.5f;
  EXPECT_EQ(projection().faces(), 1);
  EXPECT_FLOAT_EQ(projection().high, std::tan(0.5f));
  light.outer_cone_angle = 1.2f;
  EXPECT_EQ(projection().faces(), 6);
  light.type = LightType::directional;
  EXPECT_TRUE(projection().parallel);
  EXPECT_EQ(projection().farthest, 10.0f);
}

TEST(ShadowBias, IsThePapers) {
  // [SSDO sec. 5] b = (p/2) tan(alpha): at 45 degrees half a patch; none head-on; clamped.
  EXPECT_FLOAT_EQ(shadow_patch_size(8.0f, 512.0f), std::sqrt(2.0f) / 64.0f);
  EXPECT_NEAR(shadow_slope_bias(0.2f, std::sqrt(0.5f), 10.0f), 0.1f, 1e-6f);
  EXPECT_EQ(shadow_slope_bias(0.2f, 1.0f, 10.0f), 0.0f);
  EXPECT_FLOAT_EQ(shadow_slope_bias(0.2f, 1e-6f, 10.0f), 1.0f);
}

TEST(VirtualLights, AndTheBounceNearbyShareTheLight) {
  // min(1, d^2/c^2) of a virtual light and the rest of the bounce make 1 at every distance.
  PunctualLight light{};
  light.position_and_type = glm::vec4(0, 1, 0, 0);
  light.direction_and_outer = glm::vec4(0, -1, 0, 0);
  light.intensity_and_inner = glm::vec4(1, 2, 3, 0);
  for (const float d : {0.05f, 0.2f, 0.5f, 0.7f}) {
    const glm::vec3 p(0, 1.0f - d, 0);
    const IncidentLight whole = incident_virtual_light(light, p, 1e-6f);
    const IncidentLight clamped = incident_virtual_light(light, p, 0.5f);
    EXPECT_NEAR(clamped.irradiance.y + clamped_share(d, 0.5f) * whole.irradiance.y,
                whole.irradiance.y, 1e-4f * whole.irradiance.y);
    EXPECT_NEAR(whole.irradiance.z, 3.0f / (d * d), 1e-3f / (d * d));
    EXPECT_EQ(whole.direction.y, 1.0f);
  }
  // It sends nothing backwards.
  EXPECT_EQ(incident_virtual_light(light, glm::vec3(0, 2, 0), 0.5f).irradiance.x, 0.0f);
}

}  // namespace
}  // namespace occlab::test
