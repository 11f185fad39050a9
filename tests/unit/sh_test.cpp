// renderers/shared/sh.h and sh_rotation.h against quadrature and closed forms.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "renderers/scene/environment.h"
#include "renderers/shared/frame.h"
#include "renderers/shared/sh_rotation.h"

namespace occlab {
namespace {

constexpr double pi_d = std::numbers::pi;

double coefficient(const Sh4& sh, int i) {
  const std::array<const vec4*, 4> parts = {&sh.c0, &sh.c1, &sh.c2, &sh.c3};
  return double((*parts[std::size_t(i) / 4])[i % 4]);
}

double band(const vec4& zonal, int l) { return double(zonal[l]); }

/// Quadrature over the sphere: the midpoint rule, exact in phi for the trigonometric polynomials
/// here and with an error below 1e-6 in cos theta.
void for_each_direction(const std::function<void(glm::dvec3, double)>& visit) {
  constexpr int rows = 2000;
  constexpr int columns = 16;
  for (int j = 0; j < rows; ++j) {
    const double z = -1.0 + 2.0 * (j + 0.5) / rows;
    const double r = std::sqrt(1.0 - z * z);
    for (int i = 0; i < columns; ++i) {
      const double phi = 2.0 * pi_d * (i + 0.5) / columns;
      visit({r * std::cos(phi), r * std::sin(phi), z}, 4.0 * pi_d / (rows * columns));
    }
  }
}

std::vector<glm::vec3> random_directions(int count, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<float> normal;
  std::vector<glm::vec3> directions;
  while (int(directions.size()) < count) {
    const glm::vec3 v(normal(generator), normal(generator), normal(generator));
    if (glm::length(v) > 1e-3f) directions.push_back(glm::normalize(v));
  }
  return directions;
}

TEST(Sh, BasisIsOrthonormal) {
  std::array<std::array<double, 16>, 16> products{};
  for_each_direction([&](glm::dvec3 d, double weight) {
    const Sh4 y = sh_basis(vec3(d));
    for (int i = 0; i < 16; ++i) {
      for (int k = 0; k < 16; ++k) {
        products[std::size_t(i)][std::size_t(k)] += weight * coefficient(y, i) * coefficient(y, k);
      }
    }
  });
  for (int i = 0; i < 16; ++i) {
    for (int k = 0; k < 16; ++k) {
      EXPECT_NEAR(products[std::size_t(i)][std::size_t(k)], i == k ? 1.0 : 0.0, 1e-5)
          << i << " " << k;
    }
  }
}

TEST(Sh, SignsAndOrderAreSloans) {
  // The leading terms of "Stupid SH Tricks" appendix A2 at directions that single them out.
  const double h = std::sqrt(0.5);
  const auto y = [](glm::dvec3 d, int i) { return coefficient(sh_basis(vec3(d)), i); };
  EXPECT_NEAR(y({0, 1, 0}, 1), -std::sqrt(3.0 / (4.0 * pi_d)), 1e-6);
  EXPECT_NEAR(y({0, 0, 1}, 2), std::sqrt(3.0 / (4.0 * pi_d)), 1e-6);
  EXPECT_NEAR(y({1, 0, 0}, 3), -std::sqrt(3.0 / (4.0 * pi_d)), 1e-6);
  EXPECT_NEAR(y({h, h, 0}, 4), 0.5 * std::sqrt(15.0 / (4.0 * pi_d)), 1e-6);
  EXPECT_NEAR(y({0, h, h}, 5), -0.5 * std::sqrt(15.0 / (4.0 * pi_d)), 1e-6);
  EXPECT_NEAR(y({0, 0, 1}, 6), std::sqrt(5.0 / (4.0 * pi_d)), 1e-6);
  EXPECT_NEAR(y({h, 0, h}, 7), -0.5 * std::sqrt(15.0 / (4.0 * pi_d)), 1e-6);
  EXPECT_NEAR(y({1, 0, 0}, 8), std::sqrt(15.0 / (16.0 * pi_d)), 1e-6);
  EXPECT_NEAR(y({0, 1, 0}, 9), std::sqrt(35.0 / (32.0 * pi_d)), 1e-6);
  EXPECT_NEAR(y({0, 0, 1}, 12), std::sqrt(7.0 / (4.0 * pi_d)), 1e-6);
  EXPECT_NEAR(y({1, 0, 0}, 15), -std::sqrt(35.0 / (32.0 * pi_d)), 1e-6);
  const double c = 1.0 / std::sqrt(3.0);
  EXPECT_NEAR(y({c, c, c}, 10), std::sqrt(105.0 / (4.0 * pi_d)) * c * c * c, 1e-6);
}

TEST(Sh, ZonalRotationMatchesQuadrature) {
  // Cosine lobe about d; exact coefficients by integrating max(0, w.d) y_i(w).
  for (const glm::vec3& d : random_directions(4, 1)) {
    std::array<double, 16> expected{};
    // Quadrature in the lobe's own frame, where the kink at its edge falls on a panel's end.
    const glm::dvec3 axis(d);
    const glm::dvec3 side = glm::normalize(
        glm::cross(axis, std::abs(axis.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
    const glm::dvec3 other = glm::cross(axis, side);
    for_each_direction([&](glm::dvec3 local, double weight) {
      if (local.z <= 0.0) return;
      const Sh4 y = sh_basis(vec3(local.x * side + local.y * other + local.z * axis));
      for (int i = 0; i < 16; ++i) expected[std::size_t(i)] += weight * local.z * coefficient(y, i);
    });
    const Sh4 found = sh_zonal(sh_cosine_lobe(), d);
    for (int i = 0; i < 16; ++i) {
      EXPECT_NEAR(coefficient(found, i), expected[std::size_t(i)], 1e-5) << i;
    }
  }
}

TEST(Sh, CosineLobeHasTheClosedForm) {
  // Case E.1, an open plane: sqrt(pi)/2, sqrt(pi/3), sqrt(5 pi)/8, 0.
  const vec4 z = sh_cosine_lobe();
  EXPECT_NEAR(band(z, 0), std::sqrt(pi_d) / 2.0, 1e-6);
  EXPECT_NEAR(band(z, 1), std::sqrt(pi_d / 3.0), 1e-6);
  EXPECT_NEAR(band(z, 2), std::sqrt(5.0 * pi_d) / 8.0, 1e-6);
  EXPECT_EQ(band(z, 3), 0.0);
  // A_l = sqrt(4 pi / (2l+1)) z_l [Ramamoorthi and Hanrahan 2001].
  for (int l = 0; l < 4; ++l) {
    EXPECT_NEAR(band(sh_cosine_convolution(), l), std::sqrt(4.0 * pi_d / (2 * l + 1)) * band(z, l),
                1e-6);
  }
}

TEST(Sh, UnitWhiteResponseToADirectionalLight) {
  // The irradiance E_perp with which a light along n, at order 4, gives the irradiance pi of a unit
  // white sky: 16 pi / 17 without a window, 3.771299 with Hanning's of width 4.
  const double unwindowed = 16.0 * pi_d / 17.0;
  for (const glm::vec3& n : random_directions(4, 2)) {
    const Sh4 lobe = sh_zonal(sh_cosine_lobe(), n);
    const double response = double(sh_dot(lobe, sh_basis(n)));
    EXPECT_NEAR(response * unwindowed, pi_d, 1e-5);
    const Sh4 windowed = sh_scale_bands(sh_basis(n), sh_hanning_window(4.0f));
    EXPECT_NEAR(pi_d / double(sh_dot(lobe, windowed)), 3.771299, 1e-5);
  }
}

TEST(Sh, HanningWindowHasItsValues) {
  const vec4 w = sh_hanning_window(4.0f);
  EXPECT_NEAR(band(w, 0), 1.0, 1e-6);
  EXPECT_NEAR(band(w, 1), 0.853553, 1e-6);
  EXPECT_NEAR(band(w, 2), 0.5, 1e-6);
  EXPECT_NEAR(band(w, 3), 0.146447, 1e-6);
  EXPECT_EQ(sh_hanning_window(0.0f), vec4(1.0f));
  // Narrower than the expansion: bands from `width` on are gone, never negative or periodic.
  EXPECT_NEAR(band(sh_hanning_window(2.0f), 2), 0.0, 1e-6);
  EXPECT_NEAR(band(sh_hanning_window(2.0f), 3), 0.0, 1e-6);
}

TEST(Sh, PackingErrorIsHalfAnUlpOfAHalf) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<float> exponent(-13.9f, 15.9f);
  std::uniform_int_distribution<int> sign(0, 1);
  double largest = 0.0;
  for (int trial = 0; trial < 1000; ++trial) {
    std::array<vec4, 4> parts;
    for (vec4& part : parts) {
      for (int c = 0; c < 4; ++c) {
        part[c] = std::exp2(exponent(generator)) * (sign(generator) ? 1.0f : -1.0f);
      }
    }
    const Sh4 a = sh4(parts[0], parts[1], parts[2], parts[3]);
    const Sh4 b = sh_unpack(sh_pack_low(a), sh_pack_high(a));
    for (int i = 0; i < 16; ++i) {
      const double error = std::abs(coefficient(b, i) - coefficient(a, i));
      EXPECT_LE(error, std::ldexp(std::abs(coefficient(a, i)), -11)) << coefficient(a, i);
      largest = std::max(largest, error / std::abs(coefficient(a, i)));
    }
  }
  EXPECT_GT(largest, 0.9 * std::ldexp(1.0, -11));  // the bound is tight, and halves were used
}

Environment gradient_environment(glm::vec3 u) {
  Environment environment;
  environment.texels = Image(256, 128, 3);
  for (int y = 0; y < 128; ++y) {
    const double theta = pi_d * (y + 0.5) / 128;
    for (int x = 0; x < 256; ++x) {
      const double phi = 2.0 * pi_d * ((x + 0.5) / 256 - 0.5);
      const glm::vec3 d(std::sin(theta) * std::cos(phi), std::cos(theta),
                        std::sin(theta) * std::sin(phi));
      for (int c = 0; c < 3; ++c) environment.texels.at(x, y, c) = 1.0f + glm::dot(d, u);
    }
  }
  return environment;
}

double irradiance(const ShRgb& sh, glm::vec3 n) {
  return double(sh_dot(sh.r, sh_scale_bands(sh_basis(n), sh_cosine_convolution())));
}

TEST(ProjectSh, ConstantEnvironment) {
  // Case E.12: c_0 = 2 sqrt(pi) L, the rest 0, E = pi L.
  const glm::vec3 radiance(0.5f, 1.0f, 3.0f);
  const ShRgb sh = project_sh(constant_environment(radiance), glm::mat3(1.0f));
  const std::array<const Sh4*, 3> channels = {&sh.r, &sh.g, &sh.b};
  for (int c = 0; c < 3; ++c) {
    const Sh4& channel = *channels[std::size_t(c)];
    EXPECT_NEAR(coefficient(channel, 0), 2.0 * std::sqrt(pi_d) * double(radiance[c]), 1e-5);
    for (int i = 1; i < 16; ++i) {
      EXPECT_NEAR(coefficient(channel, i), 0.0, 1e-5 * double(radiance[c])) << i;
    }
  }
  for (const glm::vec3& n : random_directions(4, 4))
    EXPECT_NEAR(irradiance(sh, n), 0.5 * pi_d, 1e-5);
}

TEST(ProjectSh, LinearEnvironment) {
  // Case E.12: L = 1 + w.u gives E = pi + (2 pi / 3) n.u. The texels hold L at their centres, which
  // differs from their mean by less than (pi/128)^2 / 8 = 7.5e-5.
  const glm::vec3 u(0.3f, -0.6f, 0.5f);
  const ShRgb sh = project_sh(gradient_environment(u), glm::mat3(1.0f));
  for (const glm::vec3& n : random_directions(16, 5)) {
    EXPECT_NEAR(irradiance(sh, n), pi_d + 2.0 * pi_d / 3.0 * double(glm::dot(n, u)), 5e-4);
  }
}

TEST(ProjectSh, IrradianceDoesNotDependOnTheSpace) {
  // Case E.14: projecting in a turned space and asking there for the turned normal.
  Environment environment = gradient_environment({0.1f, 0.2f, -0.9f});
  environment.texels.at(40, 30, 0) = 5000.0f;  // a sun, so that all bands count
  const ShRgb world = project_sh(environment, glm::mat3(1.0f));
  const std::vector<glm::vec3> axes = random_directions(2, 6);
  const glm::vec3& x = axes[0];
  const glm::vec3 y = glm::normalize(axes[1] - glm::dot(axes[1], x) * x);
  const glm::mat3 world_from_space(x, y, glm::cross(x, y));
  const ShRgb space = project_sh(environment, world_from_space);
  for (const glm::vec3& n : random_directions(16, 7)) {
    const glm::vec3 n_space = glm::transpose(world_from_space) * n;
    const double expected = double(sh_dot(world.r, sh_basis(n)));
    EXPECT_NEAR(double(sh_dot(space.r, sh_basis(n_space))), expected,
                1e-5 * (1.0 + std::abs(expected)));
  }
}

TEST(ProjectSh, TexelsAreIntegratedNotSampled) {
  // One lit texel of a coarse probe, against a fine subdivision of that texel.
  Environment environment;
  environment.texels = Image(8, 4, 3);
  environment.texels.at(5, 1, 0) = 1.0f;
  const ShRgb sh = project_sh(environment, glm::mat3(1.0f));
  std::array<double, 16> expected{};
  constexpr int steps = 400;
  for (int j = 0; j < steps; ++j) {
    const double theta = pi_d * (1.0 + (j + 0.5) / steps) / 4.0;
    for (int i = 0; i < steps; ++i) {
      const double phi = 2.0 * pi_d * ((5.0 + (i + 0.5) / steps) / 8.0 - 0.5);
      const double weight = std::sin(theta) * (pi_d / 4.0 / steps) * (pi_d / 4.0 / steps);
      const Sh4 y = sh_basis(vec3(float(std::sin(theta) * std::cos(phi)), float(std::cos(theta)),
                                  float(std::sin(theta) * std::sin(phi))));
      for (int k = 0; k < 16; ++k) expected[std::size_t(k)] += weight * coefficient(y, k);
    }
  }
  // Gauss-Legendre over 45 degrees leaves about (pi/4)^4 l^4 / 4320 of band l = 3.
  for (int k = 0; k < 16; ++k) {
    EXPECT_NEAR(coefficient(sh.r, k), expected[std::size_t(k)], 4e-3) << k;
  }
}

/// A function turned with its space: y_i(d) of a frame is the basis at frame * d.
void expect_turns_the_basis(const mat3& frame) {
  for (const glm::vec3& d : random_directions(20, 3)) {
    const Sh4 turned = sh_basis(normalize(frame * d));
    // Orthonormal matrices: the rotation of y(d) is y(frame d).
    const Sh4 rotated = sh_rotate(sh_basis(d), frame);
    for (int i = 0; i < 16; ++i) {
      EXPECT_NEAR(coefficient(rotated, i), coefficient(turned, i), 3e-6) << i;
    }
  }
}

TEST(Sh, RotatesFromSamplingFrames) {
  std::vector<glm::vec3> normals = random_directions(100, 5);
  for (const float z : {1.0f, -1.0f}) {
    for (const float x : {0.0f, 1e-30f, 1e-12f, 1e-6f, -1e-3f, 0.1f}) {
      normals.push_back(glm::normalize(glm::vec3(x, 0.5f * x, z)));
      normals.push_back(glm::normalize(glm::vec3(0, -x, z)));
    }
  }
  for (const glm::vec3& n : normals) {
    for (const float turn : {0.0f, 0.3f, 2.0f, -3.0f}) {
      expect_turns_the_basis(sampling_frame(n, vec4(std::cos(turn), std::sin(turn), 0, 0)));
    }
  }
}

TEST(Sh, RotationOfAnyFrame) {
  // Axes onto axes, where all the angles are degenerate.
  const glm::vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  for (const mat3& frame : {mat3(x, y, z), mat3(-x, -y, z), mat3(y, z, x), mat3(z, x, y),
                            mat3(-z, y, x), mat3(x, -y, -z), mat3(-x, y, -z), mat3(y, x, -z)}) {
    expect_turns_the_basis(frame);
  }
}

}  // namespace
}  // namespace occlab
