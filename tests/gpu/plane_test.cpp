// An open plane, where every method must give the unoccluded answer.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>

#include "renderers/shared/sh.h"
#include "tests/analytic/traced_points.h"
#include "tests/gpu/gpu_frame.h"

namespace occlab::test {
namespace {

const View straight_down = look_at({0, 5, 0}, {0, 0, 0}, 0.6f, 32, 20, {0, 0, -1});
const View oblique = look_at({1, 4, 5}, {0, 0, 0}, 0.6f, 32, 20);
const View grazing = look_at({0, 0.4f, 4}, {0, 0, 0}, 0.15f, 32, 20);

/// The means of a layer's channels over the image, one a seed.
std::array<std::vector<double>, 3> image_means(const TestFrame& frame, const std::string& method,
                                               const std::string& layer, Values values, int seeds) {
  std::array<std::vector<double>, 3> means;
  values.emplace_back("filter", "none");
  for (long seed = 0; seed < seeds; ++seed) {
    values.emplace_back("seed", seed);
    const Image image = frame.layer(method, layer, values);
    glm::dvec3 sum(0.0);
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) sum += pixel3(image, x, y);
    }
    for (int c = 0; c < 3; ++c) means[c].push_back(sum[c] / double(image.pixel_count()));
  }
  return means;
}

TEST(OpenPlane, NothingIsOccludedAndAUniformSkyIsWhite) {
  for (const View& view : {straight_down, oblique, grazing}) {
    const TestFrame frame(open_floor(), view, constant_environment(glm::vec3(1.0f)));
    for (const std::string& method : screen_space_methods) {
      for (const char* filter : {"none", "bilateral"}) {
        for (const long samples : {50L}) {
          const Layers layers =
              frame.evaluate(method, {{"samples", samples}, {"steps", 3L}, {"filter", filter}});
          const Image& radiance = layers.at("radiance");
          const std::string occlusion = occlusion_layer(method);
          for (int y = 0; y < frame.height(); ++y) {
            for (int x = 0; x < frame.width(); ++x) {
              ASSERT_EQ(frame.surface().mask.at(x, y), 1.0f);
              if (!occlusion.empty()) {
                ASSERT_NEAR(layers.at(occlusion).at(x, y), 1.0f, 1e-3f) << method;
              } else {
                ASSERT_NEAR(layers.at("irradiance").at(x, y, 1), float(pi_d), 1e-3f) << method;
              }
              // A cone's light goes with |N|, which 32 azimuths leave a little above 1/2.
              ASSERT_NEAR(radiance.at(x, y, 2), 1.0f, method == "ssbn" ? 3e-3f : 1e-3f) << method;
            }
          }
        }
      }
    }
  }
}

TEST(OpenPlane, SphericalHarmonicsGiveTheirIrradiance) {
  // S3HO on an open plane is the order-4 irradiance of [Ramamoorthi and Hanrahan 2001].
  const TestFrame frame(open_floor(), oblique, load_environment({.source = "sky_sun"}));
  const glm::vec3 n(frame.frame().view.view_from_world() * glm::vec4(0, 1, 0, 0));
  const Sh4 lobe = sh_scale_bands(sh_basis(n), sh_cosine_convolution());
  const ShRgb& light = frame.frame().lighting.sh_view();
  const glm::vec3 expected = sh_dot_rgb(light, lobe);
  const Sh4 channels[3] = {light.r, light.g, light.b};
  const auto means = image_means(frame, "s3ho", "radiance", {{"samples", 256L}}, 8);
  for (int c = 0; c < 3; ++c) {
    // Halves: a last bit of each term.
    double halves = 0.0;
    for (int i = 0; i < 4; ++i) {
      halves += double(std::abs(channels[c].c0[i] * lobe.c0[i]) +
                       std::abs(channels[c].c1[i] * lobe.c1[i]) +
                       std::abs(channels[c].c2[i] * lobe.c2[i]));
    }
    EXPECT_TRUE(agrees(mean_of(means[c]), double(expected[c]) / pi_d, 0x1p-10 * halves / pi_d))
        << c;
  }
}

TEST(OpenPlane, LookedUpRadianceConvergesToTheIntegral) {
  // SSDO's estimate is unbiased but for the height strata, however rough the probe.
  const Environment probe = probe_of(32, [](glm::vec3 d) {
    return glm::vec3(0.5f + 0.5f * std::sin(7 * d.x + 3 * d.z), d.y > 0.5f ? 3.0f : 0.25f,
                     d.x > 0 && d.z > 0 ? 4.0f : 0.0f);
  });
  const TestFrame frame(open_floor(), oblique, probe);
  const int rows = probe.texels.height();
  const auto means = image_means(frame, "ssdo", "irradiance", {{"samples", 256L}}, 16);
  for (int c = 0; c < 3; ++c) {
    double expected = 0.0;
    for (int y = 0; y < rows / 2; ++y) {
      const double top = std::cos(pi_d * y / rows), bottom = std::cos(pi_d * (y + 1) / rows);
      for (int x = 0; x < 2 * rows; ++x) {
        expected +=
            double(probe.texels.at(x, y, c)) * pi_d / (2 * rows) * (top * top - bottom * bottom);
      }
    }
    const Mean irradiance = mean_of(means[c]);
    // A ring of height 1/N may fall to either side of a texel row's edge: 1/N of the largest step.
    EXPECT_TRUE(agrees(irradiance, expected, 3.0 * 2.0 * pi_d / 256.0)) << c;
    EXPECT_LT(irradiance.standard_error, 0.02 * expected) << c;
  }
}

TEST(OpenPlane, BentNormalIsHalfTheNormal) {
  const TestFrame frame(open_floor(), oblique, constant_environment(glm::vec3(1.0f)));
  const glm::dvec3 n(glm::vec3(frame.frame().view.view_from_world() * glm::vec4(0, 1, 0, 0)));
  const Layers layers = frame.evaluate("ssbn", {{"samples", 64L}, {"filter", "none"}});
  glm::dvec3 sum(0.0);
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) {
      const glm::dvec3 bent = pixel3(layers.at("bent_normal"), x, y);
      sum += bent / double(layers.at("bent_normal").pixel_count());
      EXPECT_NEAR(glm::dot(bent, n), 0.5, 1e-5);
      EXPECT_NEAR(glm::length(bent), 0.5, 1e-3) << "the cone is the hemisphere";
    }
  }
  EXPECT_LT(glm::length(sum - 0.5 * n), 1e-5) << "the 16 turns cancel what is left sideways";
}

TEST(OpenPlane, SixteenSetsRepeatInAFourByFourPattern) {
  const TestFrame frame(open_floor(), oblique, load_environment({.source = "cathedral"}));
  const Image irradiance =
      frame.layer("ssdo", "irradiance", {{"samples", 16L}, {"filter", "none"}});
  // The interpolated normal differs by rounding, which may carry a direction into the next texel.
  std::set<float> values;
  int repeated = 0;
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) {
      repeated +=
          std::abs(irradiance.at(x, y) - irradiance.at(x & 3, y & 3)) <= 1e-4f * irradiance.at(x, y)
              ? 1
              : 0;
      if (x < 4 && y < 4) values.insert(irradiance.at(x, y));
    }
  }
  EXPECT_GT(repeated, int(0.95 * frame.width() * frame.height()));
  EXPECT_EQ(values.size(), 16u);
}

TEST(OpenPlane, SeedsChangeTheSamplesAndNothingElseDoes) {
  const TestFrame frame(open_floor(), oblique, load_environment({.source = "cathedral"}));
  const auto render = [&](long seed) {
    return frame.layer("ssdo", "radiance", {{"seed", seed}, {"samples", 8L}});
  };
  EXPECT_EQ(render(1), render(1));
  EXPECT_NE(render(1), render(2));
}

TEST(OpenPlane, ALevelFloorIsEvenlyLit) {
  // It faces the probe's pole, where the azimuth is anyone's guess.
  const TestFrame frame(open_floor(), oblique, load_environment({.source = "cathedral"}));
  const Image radiance = frame.layer("ssao", "radiance", {{"filter", "none"}});
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(radiance.at(x, y, c), radiance.at(0, 0, c), 3e-3f * radiance.at(0, 0, c));
      }
    }
  }
}

TEST(OpenPlane, BackgroundIsZeroInEveryLayer) {
  const View horizon = look_at({0, 1, 5}, {0, 1, 0}, 0.8f, 32, 20);
  const TestFrame frame(open_floor(), horizon, constant_environment(glm::vec3(1.0f)));
  for (const std::string& method : screen_space_methods) {
    for (const char* filter : {"none", "bilateral"}) {
      const Layers layers = frame.evaluate(method, {{"filter", filter}});
      EXPECT_EQ(layers.find("radiance_unfiltered") != nullptr, std::string(filter) != "none");
      for (const Layers::Layer& layer : layers.all()) {
        for (int x = 0; x < frame.width(); ++x) {
          for (const float value : layer.image.pixel(x, 2)) EXPECT_EQ(value, 0.0f) << layer.name;
        }
        // Nothing is off the screen there, so that share is rightly 0.
        if (layer.name == "off_screen") continue;
        const auto below = layer.image.pixel(16, 18);
        EXPECT_TRUE(std::ranges::any_of(below, [](float value) { return value != 0.0f; }))
            << layer.name;
      }
      EXPECT_EQ(frame.surface().mask.at(16, 2), 0.0f);
      // Bright all the same at the horizon: the filter leaves the background out.
      EXPECT_NEAR(layers.at("radiance").at(16, 11), 1.0f, 5e-3f) << method;
    }
  }
}

TEST(OpenPlane, ReflectanceAndExposureScaleTheRadiance) {
  const Scene scene = SceneBuilder()
                          .add(quad({-9, 0, -9}, {0, 0, 18}, {18, 0, 0}))
                          .material({0.25f, 0.5f, 0.75f})
                          .build();
  const TestFrame frame(scene, oblique, constant_environment({2.0f, 3.0f, 4.0f}));
  for (const std::string& method : screen_space_methods) {
    const Image radiance = frame.layer(method, "radiance", {});
    EXPECT_LT(glm::length(pixel3(radiance, 9, 9) - glm::dvec3(0.5, 1.5, 3.0)), 1e-2) << method;
  }
}

TEST(OpenPlane, NegativeLightIsCutAndCounted) {
  // A small lamp below the horizon: its order-4 reconstruction rings into negative values above.
  const TestFrame frame(
      open_floor(), straight_down, probe_of(64, [](glm::vec3 d) {
        return glm::vec3(d.y < -0.2f && d.y > -0.35f && d.x > 0.9f ? 50.0f : 0.0f);
      }));
  Metadata facts;
  const Image radiance = frame.evaluate("s3ho", {{"filter", "none"}}, &facts).at("radiance");
  std::size_t black = 0;
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) {
      EXPECT_GE(radiance.at(x, y), 0.0f);
      black += radiance.at(x, y) == 0.0f ? 1 : 0;
    }
  }
  const glm::vec3 n(frame.frame().view.view_from_world() * glm::vec4(0, 1, 0, 0));
  const float expected = sh_dot(frame.frame().lighting.sh_view().r,
                                sh_scale_bands(sh_basis(n), sh_cosine_convolution()));
  EXPECT_EQ(facts.at("negative_pixels"), std::to_string(black));
  EXPECT_EQ(black > 0, expected < 0.0f) << expected;
}

TEST(OpenPlane, SixteenBitGeometryRuns) {
  // Rounded positions occlude themselves [S3HO sec. 3 has them all the same]: finite, within range,
  // and different.
  const TestFrame frame(open_floor(), oblique, constant_environment(glm::vec3(1.0f)));
  for (const std::string& method : screen_space_methods) {
    const Image radiance =
        frame.layer(method, "radiance", {{"gbuffer_bits", "16"}, {"filter", "none"}});
    for (int y = 0; y < frame.height(); ++y) {
      for (int x = 0; x < frame.width(); ++x) {
        EXPECT_GE(radiance.at(x, y), 0.3f) << method;
        EXPECT_LE(radiance.at(x, y), method == "ssbn" ? 1.05f : 1.001f) << method;
      }
    }
    EXPECT_NE(radiance, frame.layer(method, "radiance", {{"filter", "none"}})) << method;
  }
}

}  // namespace
}  // namespace occlab::test
