// The bilateral filter: what it must not change, what it must remove, what may leak.

#include "renderers/shared/filter.h"

#include <gtest/gtest.h>

#include "tests/gpu/gpu_frame.h"

namespace occlab::test {
namespace {

const View corner_view = look_at({4, 3, 5}, {0, 0.6f, 0}, 0.5f, 48, 37);

/// The filter of a representation, evaluated here.
Image filtered(const GBufferImages& surface, const Image& input, float power, float scale) {
  Image output(input.width(), input.height(), input.channels());
  const auto at = [](const Image& image, int x, int y) { return glm::vec3(pixel3(image, x, y)); };
  for (int y = 0; y < input.height(); ++y) {
    for (int x = 0; x < input.width(); ++x) {
      if (surface.mask.at(x, y) == 0.0f) continue;
      std::vector<double> sum(std::size_t(input.channels()));
      double weights = 0.0;
      for (int v = std::max(0, y - 4); v <= std::min(input.height() - 1, y + 3); ++v) {
        for (int u = std::max(0, x - 4); u <= std::min(input.width() - 1, x + 3); ++u) {
          if (surface.mask.at(u, v) == 0.0f) continue;
          const double w = double(bilateral_weight(
              at(surface.position_view, x, y), at(surface.normal_view, x, y),
              at(surface.position_view, u, v), at(surface.normal_view, u, v), power, -1, scale));
          weights += w;
          for (int c = 0; c < input.channels(); ++c) {
            sum[std::size_t(c)] += w * double(input.at(u, v, c));
          }
        }
      }
      for (int c = 0; c < input.channels(); ++c) {
        output.at(x, y, c) = float(sum[std::size_t(c)] / weights);
      }
    }
  }
  return output;
}

double largest_difference(const Image& a, const Image& b) {
  EXPECT_EQ(a.values().size(), b.values().size());
  double largest = 0.0;
  for (std::size_t i = 0; i < a.values().size(); ++i) {
    largest = std::max(largest, double(std::abs(a.values()[i] - b.values()[i])));
  }
  return largest;
}

TEST(Filter, WeightIsThePapers) {
  // ((n.n')/2 + 1/2)^power / (1 + |p-p'|/scale)^2.
  const glm::vec3 p(1, 2, 3), n(0, 0, 1), slanted(0, 0.6f, 0.8f);
  EXPECT_FLOAT_EQ(bilateral_weight(p, n, p, n, 5, 5, 1), 1.0f);
  EXPECT_FLOAT_EQ(bilateral_weight(p, n, p + glm::vec3(0, 2, 0), n, 5, 5, 2), 0.25f);
  EXPECT_NEAR(bilateral_weight(p, n, p, {1, 0, 0}, 5, -1, 1), 1.0 / 32.0, 1e-7) << "90 degrees";
  EXPECT_NEAR(bilateral_weight(p, n, p, slanted, 3, 3, 1), 0.9 * 0.9 * 0.9, 1e-6);
  EXPECT_EQ(bilateral_weight(p, n, p, -n, 5, 5, 1), 0.0f);
}

TEST(Filter, WholePowersAreThoseOfPow) {
  for (const int n : {0, 1, 2, 5, 32, 100, 1023}) {
    for (const float x : {0.0f, 0.5f, 0.97f, 1.0f}) {
      EXPECT_NEAR(whole_power(x, n), std::pow(x, float(n)), 1e-6f) << x << "^" << n;
    }
  }
}

TEST(Filter, EachRepresentationIsFilteredAsComputedHere) {
  const TestFrame frame(floor_and_tall_wall(3.0f), corner_view,
                        load_environment({.source = "sky_sun"}));
  EXPECT_EQ(frame.surface().mask.at(47, 0), 0.0f) << "some background beside the edges";
  const std::vector<std::pair<std::string, std::string>> layers = {{"ssao", "ambient_occlusion"},
                                                                   {"s3ho", "sh_visibility"},
                                                                   {"ssdo", "irradiance"},
                                                                   {"ssbn", "uniform_occlusion"},
                                                                   {"ssbn", "bent_normal"}};
  for (const auto& [method, layer] : layers) {
    const Values values = {{"filter_power", 5.0}, {"filter_scale", 0.7}, {"d_max_world", 1.5}};
    Values unfiltered = values;
    unfiltered.emplace_back("filter", "none");
    const Image before = frame.layer(method, layer, unfiltered);
    const Image expected = filtered(frame.surface(), before, 5.0f, 0.7f * 1.5f);
    float largest = 0.0f;
    for (const float value : before.values()) largest = std::max(largest, std::abs(value));
    // Floats, or halves for the harmonics.
    const double rounding = method == "s3ho" ? 0x1p-10 : 1e-5;
    EXPECT_LT(largest_difference(frame.layer(method, layer, values), expected), rounding * largest)
        << method << " " << layer;
    EXPECT_GT(largest_difference(before, expected), 100 * rounding * largest)
        << "nothing to filter";
  }
}

TEST(Filter, ConstantsAreKept) {
  const TestFrame frame(floor_and_tall_wall(3.0f), corner_view,
                        constant_environment(glm::vec3(1.0f)));
  // So short a reach that nothing is occluded.
  for (const std::string& method : screen_space_methods) {
    if (method == "ssbn") continue;  // its cone differs from set to set
    const Image radiance = frame.layer(method, "radiance", {{"d_max_world", 1e-3}});
    for (int y = 0; y < frame.height(); ++y) {
      for (int x = 0; x < frame.width(); ++x) {
        if (frame.surface().mask.at(x, y) == 0.0f) continue;
        EXPECT_NEAR(radiance.at(x, y), 1.0f, 1e-3f) << method;
      }
    }
  }
}

TEST(Filter, AFlatWindowRemovesTheFourByFourPatternAndKeepsItsMean) {
  // With a flat distance weight every 8x8 window of a plane holds each of the 16 sets 4 times.
  const View view = look_at({1, 4, 5}, {0, 0, 0}, 0.6f, 32, 24);
  const TestFrame frame(open_floor(), view, probe_of(64, [](glm::vec3 d) {
                          return glm::vec3(1.0f + std::sin(5 * d.x) * std::cos(4 * d.z));
                        }));
  const Values few = {{"samples", 4L}, {"filter_scale", 1e6}, {"d_max_world", 1.0}};
  Values unfiltered = few;
  unfiltered.emplace_back("filter", "none");
  const Image before = frame.layer("ssdo", "irradiance", unfiltered);
  const Image after = frame.layer("ssdo", "irradiance", few);
  double pattern_mean = 0.0;
  for (int y = 4; y < 8; ++y) {
    for (int x = 4; x < 8; ++x) pattern_mean += double(before.at(x, y)) / 16.0;
  }
  double spread = 0.0;
  for (int y = 4; y < 8; ++y) {
    for (int x = 4; x < 8; ++x) {
      spread = std::max(spread, std::abs(double(before.at(x, y)) - pattern_mean));
    }
  }
  EXPECT_GT(spread, 0.05 * pattern_mean);
  for (int y = 4; y < frame.height() - 4; ++y) {
    for (int x = 4; x < frame.width() - 4; ++x) {
      // A direction on a texel's edge may see either side of it: hence not to the last bit.
      EXPECT_NEAR(after.at(x, y), pattern_mean, 0.02 * spread) << x << " " << y;
    }
  }
}

TEST(Filter, LeakAroundACornerIsBounded) {
  // Light from behind the wall alone reaches the floor and none of it the wall.
  const TestFrame frame(floor_and_tall_wall(3.0f), corner_view, probe_of(64, [](glm::vec3 d) {
                          return glm::vec3(d.x < 0.0f ? 1.0f : 0.0f);
                        }));
  const glm::dvec3 wall_normal(
      glm::vec3(frame.frame().view.view_from_world() * glm::vec4(1, 0, 0, 0)));
  const auto largest_leak = [&](double power) {
    const Values values = {
        {"d_max_world", 1e-3}, {"samples", 64L}, {"filter_power", power}, {"filter_scale", 1e6}};
    const Image irradiance = frame.layer("ssdo", "irradiance", values);
    double leak = 0.0;
    for (int y = 0; y < frame.height(); ++y) {
      for (int x = 0; x < frame.width(); ++x) {
        const bool wall = glm::dot(pixel3(frame.surface().normal_view, x, y), wall_normal) > 0.9;
        if (wall) leak = std::max(leak, double(irradiance.at(x, y)));
      }
    }
    return leak / (0.5 * pi_d);  // of what the floor has
  };
  // Beside the edge up to 39 of the window's 64 pixels are the floor's, at (1/2)^power each.
  EXPECT_GT(largest_leak(5.0), 0.01);
  EXPECT_LT(largest_leak(5.0), 1.1 * (39.0 / 25.0) / 32.0);
  EXPECT_LT(largest_leak(32.0), 1e-6) << "the default";
  EXPECT_GT(largest_leak(0.0), 0.3) << "without the orientation weight";
}

TEST(Filter, UnfilteredRadianceIsThatOfNoFilter) {
  const TestFrame frame(floor_and_tall_wall(3.0f), corner_view,
                        load_environment({.source = "cathedral"}));
  for (const std::string& method : screen_space_methods) {
    const Layers both = frame.evaluate(method, {});
    EXPECT_EQ(both.at("radiance_unfiltered"),
              frame.layer(method, "radiance", {{"filter", "none"}}));
    EXPECT_NE(both.at("radiance_unfiltered"), both.at("radiance"));
  }
}

}  // namespace
}  // namespace occlab::test
