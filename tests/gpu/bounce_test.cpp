// One bounce in the passes: what it is made of, and what the two methods must make of a corner.

#include <gtest/gtest.h>

#include <algorithm>

#include "renderers/methods/cpu_passes.h"
#include "renderers/shared/representation_sh4.h"
#include "tests/gpu/gpu_frame.h"

namespace occlab::test {
namespace {

/// A grey floor between a red wall at x = 0 and a low green one at x = 2.
Scene coloured_corner() {
  return SceneBuilder()
      .add(quad({0, 0, -6}, {0, 0, 12}, {8, 0, 0}))
      .material({0.6f, 0.6f, 0.6f})
      .add(quad({0, 0, -6}, {0, 4, 0}, {0, 0, 12}))
      .material({0.9f, 0.1f, 0.05f})
      .add(quad({2, 0, -6}, {0, 0, 12}, {0, 0.6f, 0}))
      .material({0.1f, 0.8f, 0.1f})
      .build();
}

const View above = look_at({1.1f, 3.5f, 3}, {0.9f, 0.2f, 0}, 0.8f, 64, 48);

Environment sky() {
  return probe_of(64, [](glm::vec3 d) { return glm::vec3(1.2f + d.x, 1.0f, 1.1f - 0.5f * d.y); });
}

std::vector<Light> lamp() {
  return {{.name = "lamp", .position_world = {1.2f, 1.5f, 0.3f}, .intensity = {1, 1.5f, 2}}};
}

float largest_difference(const Image& a, const Image& b) {
  float largest = 0.0f;
  for (std::size_t i = 0; i < a.values().size(); ++i) {
    largest = std::max(largest, std::abs(a.values()[i] - b.values()[i]));
  }
  return largest;
}

Image sum(const Image& a, const Image& b) {
  Image result = a;
  for (std::size_t i = 0; i < a.values().size(); ++i) result.values()[i] += b.values()[i];
  return result;
}

TEST(Bounce, IsAddedToTheDirectLight) {
  const TestFrame frame(coloured_corner(), above, sky(), lamp());
  for (const auto& [with, without] : {std::pair("s3hogi", "s3ho"), std::pair("ssdogi", "ssdo")}) {
    for (const char* filter : {"bilateral", "none"}) {
      const Values values = {{"filter", filter}, {"d_max_world", 0.8}};
      const Layers bounced = frame.evaluate(with, values);
      const Layers direct = frame.evaluate(without, values);
      EXPECT_LT(largest_difference(bounced.at("radiance"),
                                   sum(direct.at("radiance"), bounced.at("radiance_indirect"))),
                2e-6f)
          << with;
      EXPECT_GT(std::ranges::max(bounced.at("radiance_indirect").values()), 0.02f) << with;
      if (filter == std::string("none")) {
        EXPECT_EQ(bounced.find("radiance_indirect_unfiltered"), nullptr);
        continue;
      }
      EXPECT_LT(largest_difference(bounced.at("radiance_unfiltered"),
                                   sum(direct.at("radiance_unfiltered"),
                                       bounced.at("radiance_indirect_unfiltered"))),
                2e-6f)
          << with;
    }
  }
}

TEST(Bounce, OfNothingIsNothing) {
  // An open floor has no blockers, and black ones send nothing.
  const TestFrame open(open_floor(), look_at({0, 3, 5}, {0, 0, 0}, 0.6f, 40, 30), sky());
  const TestFrame black(SceneBuilder()
                            .add(quad({0, 0, -6}, {0, 0, 12}, {8, 0, 0}))
                            .material({0, 0, 0})
                            .add(quad({0, 0, -6}, {0, 4, 0}, {0, 0, 12}))
                            .material({0, 0, 0})
                            .build(),
                        above, sky(), lamp());
  for (const std::string& method : bounce_methods) {
    for (const TestFrame* frame : {&open, &black}) {
      const Image indirect = frame->layer(method, "radiance_indirect", {{"filter", "none"}});
      EXPECT_EQ(largest_difference(indirect, Image(indirect.width(), indirect.height(), 3)), 0.0f)
          << method;
    }
  }
}

TEST(Bounce, HasTheSendersColourAndScalesWithItsArea) {
  const TestFrame frame(coloured_corner(), above, sky());
  for (const std::string& method : bounce_methods) {
    const Values patch = {{"filter", "none"}, {"form_factor", "patch"}, {"sender_area", 1.0}};
    const Values twice = {{"filter", "none"}, {"form_factor", "patch"}, {"sender_area", 2.0}};
    const Image once = frame.layer(method, "radiance_indirect", patch);
    const Image doubled = frame.layer(method, "radiance_indirect", twice);
    // Beside the red wall red arrives, beside the green one green.
    double red = 0.0, green = 0.0;
    double of_once = 0.0, of_doubled = 0.0;
    for (int y = 0; y < frame.height(); ++y) {
      for (int x = 0; x < frame.width(); ++x) {
        const glm::dvec3 n = pixel3(frame.surface().normal_view, x, y);
        const glm::vec3 world = frame.frame().view.world_from_view_rotation() * glm::vec3(n);
        if (world.y < 0.9f) continue;
        const glm::dvec3 L = pixel3(once, x, y);
        red += std::max(L.x - L.y, 0.0);
        green += std::max(L.y - L.x, 0.0);
        of_once += L.x + L.y + L.z;
        const glm::dvec3 other = pixel3(doubled, x, y);
        of_doubled += other.x + other.y + other.z;
      }
    }
    EXPECT_GT(red, 0.05) << method;
    EXPECT_GT(green, 0.05) << method;
    EXPECT_NEAR(of_doubled / of_once, 2.0, 5e-3) << method;
  }
}

TEST(Bounce, OfUnoccludedSendersIsBrighterInCorners) {
  // [S3HO sec. 2.3]: SSDO's senders are in their own shadows there. With one form factor, the same
  // samples and a sky that order-4 SH hold, no pixel may be darker.
  const TestFrame frame(coloured_corner(), above, constant_environment(glm::vec3(1.0f)));
  for (const char* factor : {"solid_angle", "patch"}) {
    const Values values = {{"filter", "none"}, {"form_factor", factor}, {"d_max_world", 0.8}};
    const Image unoccluded = frame.layer("s3hogi", "radiance_indirect", values);
    const Image shaded = frame.layer("ssdogi", "radiance_indirect", values);
    std::size_t lit = 0, brighter = 0;
    double sums[2] = {};
    for (std::size_t i = 0; i < shaded.values().size(); ++i) {
      const float a = unoccluded.values()[i];
      const float b = shaded.values()[i];
      ASSERT_GE(a, b - 2e-3f * (1.0f + b)) << factor << " " << i;
      lit += a > 1e-2f ? 1 : 0;
      brighter += a > 1e-2f && a > 1.02f * b ? 1 : 0;
      sums[0] += double(a);
      sums[1] += double(b);
    }
    EXPECT_GT(lit, 300u);
    EXPECT_GT(double(brighter), 0.95 * double(lit)) << factor;
    EXPECT_GT(sums[0], 1.1 * sums[1]) << factor;
  }
}

TEST(Bounce, OfS3HOGIIsASumOverSenders) {
  // E_ind = sum (1 - V) f L_o, L_o = (rho/pi) c[Lin] . c[cos]: of one direction, step and sender it
  // is known from the G-buffer alone. All samples of a traced furnace are in occlab verify.
  const TestFrame frame(coloured_corner(), above, sky());
  const Image shown = frame.layer(
      "s3hogi", "radiance_indirect",
      {{"filter", "none"}, {"visibility", "traced"}, {"d_max_world", 0.7}, {"samples", 256L}});
  // The red wall sends rho/pi E(+X) in every direction: light beside it is proportional to that.
  const ShRgb& light = frame.frame().lighting.sh_view();
  const glm::vec3 wall_normal =
      glm::transpose(frame.frame().view.world_from_view_rotation()) * glm::vec3(1, 0, 0);
  const Sh4 lobe = sh_zonal(sh_cosine_lobe(), wall_normal);
  const glm::vec3 sent = glm::vec3(0.9f, 0.1f, 0.05f) * sh_dot_rgb(light, lobe) / pi;
  int looked_at = 0;
  glm::dvec3 sums(0.0);
  for (int y = 0; y < frame.height(); ++y) {
    for (int x = 0; x < frame.width(); ++x) {
      const glm::vec3 p =
          glm::vec3(frame.frame().view.camera.world_from_camera *
                    glm::vec4(glm::vec3(pixel3(frame.surface().position_view, x, y)), 1.0f));
      // On the floor, within reach of the red wall alone, and of no end of it.
      if (p.y > 1e-3f || p.x < 0.05f || p.x > 0.6f || std::abs(p.z) > 4.0f) continue;
      const double a = double(p.x) / 0.7;
      const double share = std::acos(a) - a * std::sqrt(1.0 - a * a);
      for (int c = 0; c < 3; ++c) {
        const double expected = 0.6 / pi_d * share * double(sent[c]);
        // A pixel's 256 directions leave the share uncertain by a few of them.
        EXPECT_NEAR(double(shown.at(x, y, c)), expected, 0.03 * double(sent[0])) << x << " " << y;
        sums[c] += double(shown.at(x, y, c)) / expected;
      }
      ++looked_at;
    }
  }
  EXPECT_GT(looked_at, 50);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sums[c] / looked_at, 1.0, 5e-3) << c;
}

}  // namespace
}  // namespace occlab::test
