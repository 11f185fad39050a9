#include "renderers/scene/environment.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "renderers/scene/error.h"
#include "renderers/scene/image_io.h"
#include "renderers/scene/parallel.h"
#include "renderers/shared/equirect.h"
#include "tests/unit/tiny_probes.h"
#include "tests/unit/tiny_scenes.h"

namespace occlab {
namespace {

using test::centre;
using test::energy;
using test::grey;
using test::pi_d;
using test::rough_image;
using test::texel_direction;

class ProbeFile : public testing::Test {
 protected:
  std::filesystem::path write(const Image& image, const std::string& name = "probe.exr") {
    Layers layers;
    layers.add("", image);
    write_exr(folder_ / name, layers, {});
    return folder_ / name;
  }
  Environment load(const Image& image, ProbeSettings settings = {}) {
    settings.source = write(image).string();
    return load_environment(settings);
  }
  void expect_refused(const Image& image, std::vector<std::string> parts) {
    parts.emplace_back("probe.exr");
    test::expect_error<InputError>([&] { load(image); }, parts);
  }

  TemporaryFolder folder_;
};

TEST(Equirect, ConventionAndRoundTrip) {
  const auto expect_uv = [](glm::vec3 d, float u, float v) {
    const glm::vec2 uv = equirect_uv(d);
    EXPECT_NEAR(uv.x, u, 1e-6f);
    EXPECT_NEAR(uv.y, v, 1e-6f);
  };
  expect_uv({1, 0, 0}, 0.5f, 0.5f);
  expect_uv({0, 0, 1}, 0.75f, 0.5f);
  expect_uv({0, 0, -1}, 0.25f, 0.5f);
  EXPECT_NEAR(equirect_uv({0, 1, 0}).y, 0.0f, 1e-6f);
  EXPECT_NEAR(equirect_uv({0, -1, 0}).y, 1.0f, 1e-6f);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 128; ++x) {
      const glm::vec2 uv((float(x) + 0.5f) / 128.0f, (float(y) + 0.5f) / 64.0f);
      const glm::vec3 d = equirect_direction(uv);
      EXPECT_NEAR(glm::length(d), 1.0f, 1e-6f);
      const glm::vec2 back = equirect_uv(d);
      EXPECT_NEAR(back.x, uv.x, 1e-5f);
      EXPECT_NEAR(back.y, uv.y, 1e-5f);
    }
  }
}

TEST(EnvironmentLookUp, IsNearestAndWraps) {
  Environment environment;
  environment.texels = grey(8, [](int x, int y) { return 10 * y + x; });
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 8; ++x) {
      for (const double across : {0.01, 0.5, 0.99}) {
        for (const double down : {0.01, 0.5, 0.99}) {
          const glm::vec3 d = texel_direction(environment.texels, x + across, y + down);
          EXPECT_EQ(environment.radiance(d), glm::vec3(float(10 * y + x)));
        }
      }
    }
  }
  // The seam, both poles.
  EXPECT_EQ(environment.texel({-1, 0, 0}).y, 2);
  EXPECT_EQ(environment.texel({-1, 0, 0}).x % 7, 0);
  EXPECT_EQ(environment.texel({0, 1, 0}).y, 0);
  EXPECT_EQ(environment.texel({0, -1, 0}).y, 3);
}

TEST_F(ProbeFile, RotationIsCounterClockwiseFromAbove) {
  // A light in the image's centre, +X. Turned by 90 degrees, counter-clockwise seen from +Y with +X
  // to the right and so -Z up, it stands at -Z.
  Image image = grey(64, [](int, int) { return 0.0; });
  for (int c = 0; c < 3; ++c) {
    for (const int x : {31, 32}) {
      for (const int y : {15, 16}) image.at(x, y, c) = 1.0f;
    }
  }
  const auto lit = [&](float degrees, glm::vec3 d) {
    return load(image, {.source = "", .rotation_degrees = degrees}).radiance(d).x;
  };
  const glm::vec3 tilted = glm::normalize(glm::vec3(1.0f, 0.02f, 0.02f));
  EXPECT_EQ(lit(0.0f, tilted), 1.0f);
  EXPECT_EQ(lit(90.0f, tilted), 0.0f);
  EXPECT_EQ(lit(90.0f, glm::normalize(glm::vec3(0.02f, 0.02f, -1.0f))), 1.0f);
  EXPECT_EQ(lit(90.0f, glm::normalize(glm::vec3(0.02f, 0.02f, 1.0f))), 0.0f);
  EXPECT_EQ(lit(-270.0f, glm::normalize(glm::vec3(0.02f, 0.02f, -1.0f))), 1.0f);
  const float h = std::sqrt(0.5f);
  EXPECT_EQ(lit(45.0f, glm::normalize(glm::vec3(h, 0.02f, -h))), 1.0f);
}

TEST_F(ProbeFile, ExposureIsInStops) {
  const Image image = rough_image(16, 1);
  const Environment environment = load(image, {.source = "", .exposure_stops = -2.0f});
  for (std::size_t i = 0; i < image.values().size(); ++i) {
    EXPECT_EQ(environment.texels.values()[i], 0.25f * image.values()[i]);
  }
}

TEST_F(ProbeFile, RefusesBadProbes) {
  const Image good = grey(16, [](int, int) { return 1.0; });
  expect_refused(Image(16, 9, 3), {"16x9", "twice as wide"});
  expect_refused(Image(1, 1, 3), {"1x1", "twice as wide"});
  Image bad = good;
  bad.at(5, 3, 1) = std::numeric_limits<float>::quiet_NaN();
  bad.at(6, 4, 2) = std::numeric_limits<float>::infinity();
  expect_refused(bad, {"2 of 128 texels", "NaN or infinite", "column 5, row 3"});
  bad = good;
  bad.at(2, 7, 0) = -0.011f;
  expect_refused(bad, {"1 of 128 texels", "-0.01", "column 2, row 7"});
  bad = good;
  bad.at(2, 7, 0) = 1e38f;
  test::expect_error<InputError>([&] { load(bad, {.source = "", .exposure_stops = 8.0f}); },
                                 {"exposure_stops", "8"});

  const std::string whole = test::read_bytes(write(rough_image(64, 2)));
  const auto refused_bytes = [&](const std::string& name, const std::string& bytes) {
    test::write_bytes(folder_ / name, bytes);
    test::expect_error<InputError>([&] { load_environment({.source = (folder_ / name).string()}); },
                                   {name});
  };
  refused_bytes("cut.exr", whole.substr(0, whole.size() / 2));
  refused_bytes("empty.exr", "");
  refused_bytes("text.hdr", "no radiance here");
  test::write_bytes(folder_ / "probe.png", whole);
  test::expect_error<InputError>(
      [&] { load_environment({.source = (folder_ / "probe.png").string()}); },
      {"probe.png", ".exr or .hdr"});
  test::expect_error<InputError>([] { load_environment({.source = "no/such.exr"}); },
                                 {"no/such.exr", "no such file"});
  const std::string path = write(good).string();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const ProbeSettings& settings :
       {ProbeSettings{.source = path, .rotation_degrees = nan},
        ProbeSettings{.source = path, .exposure_stops = 1e9f},
        ProbeSettings{.source = path, .prefilter_degrees = -1.0f}}) {
    test::expect_error<InputError>([&] { load_environment(settings); }, {"accepted"});
  }
}

TEST_F(ProbeFile, CountsClampedNegativeTexels) {
  Image image = grey(16, [](int, int) { return 1.0; });
  image.at(3, 3, 0) = -0.004f;
  image.at(3, 3, 1) = -0.004f;
  image.at(4, 3, 2) = -0.01f;
  const Environment environment = load(image);
  EXPECT_EQ(environment.clamped_negative_texels, 2u);
  EXPECT_EQ(environment.texels.at(3, 3, 0), 0.0f);
  EXPECT_EQ(environment.texels.at(3, 3, 2), 1.0f);
  EXPECT_EQ(environment.texels.at(4, 3, 2), 0.0f);
}

TEST_F(ProbeFile, NamesComeFromOurFolderAndFromBlender) {
  const auto blender = folder_ / "blender";
  std::filesystem::create_directories(blender / "studiolights/world");
  std::filesystem::create_directories(folder_ / "scenes/probes");
  const Image image = grey(16, [](int, int) { return 1.0; });
  write(image, "scenes/probes/ours.exr");
  write(grey(16, [](int, int) { return 2.0; }), "scenes/probes/city.exr");
  write(image, "blender/studiolights/world/city.exr");
  write(image, "blender/studiolights/world/night.exr");
  setenv("OCCLAB_DATA", (folder_ / "").c_str(), 1);
  setenv("OCCLAB_BLENDER_DATAFILES", blender.c_str(), 1);
  std::vector<std::string> names;
  for (const ProbeName& probe : probe_names()) names.push_back(probe.name);
  EXPECT_EQ(names, (std::vector<std::string>{"city", "ours", "night"}));
  const Environment city = load_environment({.source = "city"});
  EXPECT_EQ(city.name, "city");
  EXPECT_EQ(city.texels.at(0, 0), 2.0f);  // ours hides Blender's
  EXPECT_NO_THROW(load_environment({.source = "night"}));
  test::expect_error<InputError>([] { load_environment({.source = "nigth"}); },
                                 {"unknown probe 'nigth'", "did you mean 'night'", "ours"});
  unsetenv("OCCLAB_DATA");
  unsetenv("OCCLAB_BLENDER_DATAFILES");
}

TEST(Sampler, DensityIntegratesToOneAndVanishesOnlyOnBlack) {
  Environment environment;
  environment.texels = rough_image(32, 7);
  const EnvironmentSampler sampler(environment);
  double integral = 0.0;
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 32; ++x) {
      const float pdf = sampler.pdf(glm::vec3(centre(environment.texels, x, y)));
      integral += double(pdf) * texel_solid_angle(environment.texels, y);
      EXPECT_EQ(pdf > 0.0f, environment.texels.at(x, y) > 0.0f);
      // Proportional to radiance.
      EXPECT_NEAR(pdf, environment.texels.at(x, y) / energy(environment.texels),
                  1e-6 * double(pdf));
    }
  }
  EXPECT_NEAR(integral, 1.0, 1e-6);
  EXPECT_FALSE(sampler.black());
  // A texel of one colour only is sampled too, by the mean of its channels.
  environment.texels.at(3, 3, 0) = 0.0f;
  environment.texels.at(3, 3, 1) = 0.0f;
  environment.texels.at(3, 3, 2) = 6.0f;
  environment.texels.at(4, 3, 0) = environment.texels.at(4, 3, 1) = 2.0f;
  environment.texels.at(4, 3, 2) = 2.0f;
  const EnvironmentSampler coloured(environment);
  EXPECT_FLOAT_EQ(coloured.pdf(glm::vec3(centre(environment.texels, 3, 3))),
                  coloured.pdf(glm::vec3(centre(environment.texels, 4, 3))));
  const Environment night = constant_environment(glm::vec3(0.0f));
  EXPECT_TRUE(EnvironmentSampler(night).black());
  EXPECT_EQ(EnvironmentSampler(night).pdf({0, 1, 0}), 0.0f);
}

TEST(Sampler, SamplesFollowTheDensity) {
  // A turned probe; samples are binned by a grid that ignores the texels, 8 x 16 bins of equal
  // solid angle in world space, so that the position within a texel and the rotation are tested
  // too.
  Environment environment;
  environment.texels = rough_image(32, 8);
  const float c = std::cos(0.7f);
  const float s = std::sin(0.7f);
  environment.probe_from_world = {{c, 0, s}, {0, 1, 0}, {-s, 0, c}};
  const EnvironmentSampler sampler(environment);
  constexpr int rows = 8;
  constexpr int columns = 16;
  const auto bin = [](glm::vec3 d) {
    const int row = std::clamp(int((d.y + 1.0f) / 2.0f * rows), 0, rows - 1);
    const double turn = std::atan2(d.z, d.x) / (2.0 * pi_d) + 0.5;
    return std::size_t(row * columns + std::min(int(turn * columns), columns - 1));
  };
  // Expected shares: the density on a fine grid.
  std::vector<double> share(std::size_t(rows) * std::size_t(columns));
  constexpr int fine = 1024;
  for (int j = 0; j < fine; ++j) {
    const double z = -1.0 + 2.0 * (j + 0.5) / fine;
    for (int i = 0; i < 2 * fine; ++i) {
      const double phi = 2.0 * pi_d * (i + 0.5) / (2 * fine);
      const double r = std::sqrt(1.0 - z * z);
      const glm::vec3 d(r * std::cos(phi), z, r * std::sin(phi));
      share[bin(d)] += double(sampler.pdf(d)) * 4.0 * pi_d / (2.0 * fine * fine);
    }
  }
  constexpr int samples = 400000;
  std::vector<double> count(share.size());
  std::mt19937 generator(9);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  const auto draw = [&] { return std::min(uniform(generator), 0x1.fffffep-1f); };
  for (int i = 0; i < samples; ++i) {
    const auto sample = sampler.sample(draw(), draw());
    ASSERT_NEAR(glm::length(sample.direction_world), 1.0f, 1e-5f);
    ASSERT_GT(sample.pdf, 0.0f);
    ASSERT_EQ(sample.pdf, sampler.pdf(sample.direction_world));
    ASSERT_EQ(sample.radiance, environment.radiance(sample.direction_world));
    count[bin(sample.direction_world)] += 1.0;
  }
  // Chi-square, normal approximation by Wilson and Hilferty (1931). The fine grid's own error of a
  // bin's share is below 0.1%, which adds less than 0.001^2 samples = 0.4 to the statistic. False
  // alarm of a correct sampler: one-sided 4 sigma, 3e-5, and the seed is fixed.
  double chi_square = 0.0;
  double total_share = 0.0;
  int degrees = -1;
  for (std::size_t i = 0; i < share.size(); ++i) {
    total_share += share[i];
    const double expected = samples * share[i];
    if (expected < 10.0) continue;
    chi_square += (count[i] - expected) * (count[i] - expected) / expected;
    ++degrees;
  }
  EXPECT_NEAR(total_share, 1.0, 1e-3);
  ASSERT_GT(degrees, 100);
  const double k = degrees;
  const double z =
      (std::cbrt(chi_square / k) - (1.0 - 2.0 / (9.0 * k))) / std::sqrt(2.0 / (9.0 * k));
  EXPECT_LT(z, 4.0) << "chi-square " << chi_square << " with " << degrees << " degrees of freedom";
}

TEST(Sampler, IsUniformPerSolidAngleWithinATexel) {
  // One lit texel, an eighth of the sphere: height and azimuth are uniform in it.
  Environment environment;
  environment.texels = grey(4, [](int x, int y) { return x == 2 && y == 0 ? 1.0 : 0.0; });
  const EnvironmentSampler sampler(environment);
  std::mt19937 generator(12);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  constexpr int samples = 20000;
  double height = 0.0;
  double height_squared = 0.0;
  double azimuth = 0.0;
  for (int i = 0; i < samples; ++i) {
    const auto sample = sampler.sample(std::min(uniform(generator), 0x1.fffffep-1f),
                                       std::min(uniform(generator), 0x1.fffffep-1f));
    const glm::dvec3 d(sample.direction_world);
    EXPECT_NEAR(sample.pdf, 2.0 / pi_d, 1e-6);
    height += d.y / samples;
    height_squared += d.y * d.y / samples;
    azimuth += std::atan2(d.z, d.x) / (0.5 * pi_d) / samples;
  }
  // Moments of the uniform distribution within 4 of their standard errors (variances 1/12 and
  // 4/45): a false alarm has probability 6e-5 each, and the seed is fixed.
  EXPECT_NEAR(height, 0.5, 4.0 * std::sqrt(1.0 / 12.0 / samples));
  EXPECT_NEAR(azimuth, 0.5, 4.0 * std::sqrt(1.0 / 12.0 / samples));
  EXPECT_NEAR(height_squared, 1.0 / 3.0, 4.0 * std::sqrt(4.0 / 45.0 / samples));
}

TEST(Sampler, MonteCarloIntegralIsTheSum) {
  // Importance sampling by radiance makes L / pdf constant: every single sample is exact.
  Environment environment;
  environment.texels = rough_image(64, 10);
  const EnvironmentSampler sampler(environment);
  const double exact = energy(environment.texels);
  double upward = 0.0;
  double upward_squares = 0.0;
  std::mt19937 generator(11);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  constexpr int samples = 100000;
  for (int i = 0; i < samples; ++i) {
    const auto sample = sampler.sample(std::min(uniform(generator), 0x1.fffffep-1f),
                                       std::min(uniform(generator), 0x1.fffffep-1f));
    const double value = double(sample.radiance.x) / double(sample.pdf);
    ASSERT_NEAR(value / exact, 1.0, 1e-5);
    const double cosine = std::max(0.0, double(sample.direction_world.y));
    upward += value * cosine;
    upward_squares += value * cosine * value * cosine;
  }
  // Irradiance of a floor: cos theta varies within a texel, whose mean is the mean of its edges'
  // cosines. Within 4 standard errors: a false alarm has probability 6e-5, and the seed is fixed.
  double irradiance = 0.0;
  for (int y = 0; y < 16; ++y) {
    const double mean_cosine = 0.5 * (std::cos(pi_d * y / 32.0) + std::cos(pi_d * (y + 1) / 32.0));
    for (int x = 0; x < 64; ++x) {
      irradiance += double(environment.texels.at(x, y)) * mean_cosine *
                    texel_solid_angle(environment.texels, y);
    }
  }
  const double mean = upward / samples;
  const double error = std::sqrt((upward_squares / samples - mean * mean) / (samples - 1.0));
  EXPECT_NEAR(mean, irradiance, 4.0 * error);
  EXPECT_LT(error, 0.01 * irradiance);
}

TEST(ParallelFor, VisitsEveryIndexOnceAndPassesErrorsOn) {
  std::vector<std::atomic<int>> visits(1000);
  parallel_for(visits.size(), [&](std::size_t i) { ++visits[i]; });
  for (const auto& count : visits) EXPECT_EQ(count.load(), 1);
  parallel_for(0, [](std::size_t) { FAIL(); });
  for (const int threads : {1, 4}) {
    set_thread_count(threads);
    EXPECT_EQ(thread_count(), threads);
    test::expect_error<InputError>(
        [] {
          parallel_for(100, [](std::size_t i) {
            if (i == 37) throw InputError("index 37");
          });
        },
        {"index 37"});
  }
  set_thread_count(0);
  setenv("OCCLAB_THREADS", "3", 1);
  EXPECT_EQ(thread_count(), 3);
  setenv("OCCLAB_THREADS", "many", 1);
  test::expect_error<InputError>([] { thread_count(); }, {"OCCLAB_THREADS", "many", "1 to"});
  unsetenv("OCCLAB_THREADS");
}

}  // namespace
}  // namespace occlab
