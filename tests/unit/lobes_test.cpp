#include "harness/figures/lobes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "figure_images.h"
#include "harness/figures/canvas.h"
#include "harness/figures/figures.h"
#include "renderers/scene/error.h"

namespace occlab {
namespace {

constexpr float y0 = 0.2820947918f;

/// c y_00 + x y_1(-1) ..., the first four coefficients.
Sh4 first_bands(float c, float y = 0.0f, float z = 0.0f, float x = 0.0f) {
  Sh4 f = sh_zero();
  f.c0 = vec4(c, y, z, x);
  return f;
}

bool is_red(const DisplayColour& c) { return c[0] > c[1] + 0.1f && c[0] > c[2] + 0.1f; }
bool is_blue(const DisplayColour& c) { return c[2] > c[0] + 0.1f && c[2] > c[1] + 0.1f; }
bool is_paper(const DisplayColour& c) { return c == paper; }

TEST(Lobe, ReachIsTheLargestValue) {
  EXPECT_NEAR(lobe_reach(first_bands(2.0f)), 2.0 * y0, 1e-6);
  EXPECT_NEAR(lobe_reach(first_bands(-2.0f)), 2.0 * y0, 1e-6);
  // Up to the lattice's spacing of 3 degrees.
  EXPECT_NEAR(lobe_reach(first_bands(0.0f, 0.0f, 1.0f)), 0.4886025, 0.4886025 * 1.5e-3);
}

TEST(Lobe, AConstantIsABallOfItsValue) {
  constexpr int size = 100;
  // Half of the reach: a disc of 0.5 * 0.95 * 50 pixels.
  const Image image = draw_lobe(first_bands(1.0f), 2.0 * y0, size);
  int red = 0;
  for (int x = 0; x < size; ++x) red += is_red(colour_at(image, x, size / 2)) ? 1 : 0;
  EXPECT_NEAR(red, 2 * 0.5 * 0.95 * 50, 1.5);
  EXPECT_TRUE(is_red(colour_at(image, 50, 50)));
  EXPECT_TRUE(is_paper(colour_at(image, 2, 2)));
}

TEST(Lobe, SignsAndSides) {
  // y_1,1 is -x: positive to the left; y_1,-1 is -y: positive below.
  const Image sideways = draw_lobe(first_bands(0.0f, 0.0f, 0.0f, 1.0f), 0.49, 64);
  EXPECT_TRUE(is_red(colour_at(sideways, 16, 32)));
  EXPECT_TRUE(is_blue(colour_at(sideways, 48, 32)));
  const Image upright = draw_lobe(first_bands(0.0f, 1.0f), 0.49, 64);
  EXPECT_TRUE(is_red(colour_at(upright, 32, 48)));
  EXPECT_TRUE(is_blue(colour_at(upright, 32, 16)));
  // y_1,0 is z: the positive lobe is in front and hides the other.
  EXPECT_TRUE(is_red(colour_at(draw_lobe(first_bands(0.0f, 0.0f, 1.0f), 0.49, 64), 32, 32)));
  EXPECT_TRUE(is_blue(colour_at(draw_lobe(first_bands(0.0f, 0.0f, -1.0f), 0.49, 64), 32, 32)));
}

TEST(LightSphere, ShowsTheRadianceOfItsSide) {
  ShRgb light;
  light.r = first_bands(0.5f / y0);                          // .5 from everywhere
  light.g = first_bands(0.0f, 0.0f, 0.0f, -1.0f / 0.4886f);  // x: from the right
  light.b = sh_zero();
  EXPECT_NEAR(light_reach(light), 1.0, 2e-3);
  const Image image = draw_light_sphere(light, 1.0, 101);
  const float half = 1.055f * std::pow(0.5f, 1.0f / 2.4f) - 0.055f;
  EXPECT_NEAR(image.at(50, 50, 0), half, 1e-3);
  EXPECT_NEAR(image.at(50, 50, 1), 0.0f, 0.15f);
  EXPECT_NEAR(image.at(80, 50, 0), half, 1e-3);
  // x = 30 / (0.95 * 50.5) of the radius.
  const double x = 30.0 / (0.95 * 50.5);
  EXPECT_NEAR(image.at(80, 50, 1), 1.055 * std::pow(x, 1.0 / 2.4) - 0.055, 5e-3);
  EXPECT_EQ(image.at(20, 50, 1), 0.0f);
  EXPECT_TRUE(is_paper(colour_at(image, 0, 0)));
}

TEST(Lobe, RefusesSizesAndScalesWithoutMeaning) {
  EXPECT_THROW(draw_lobe(first_bands(1.0f), 1.0, 8), InputError);
  EXPECT_THROW(draw_lobe(first_bands(1.0f), 0.0, 64), InputError);
  EXPECT_THROW(draw_light_sphere(ShRgb{}, std::nan(""), 64), InputError);
}

TEST(LobeFigure, MarksPointsAndHoldsItsParts) {
  const Image picture = blank(400, 200, {0.2f, 0.4f, 0.6f});
  const Image marked = draw_points(picture, {{"p1", 100, 100}});
  EXPECT_NE(marked, picture);
  expect_colour(colour_at(marked, 300, 50), {0.2f, 0.4f, 0.6f});
  expect_colour(colour_at(marked, 100, 100), {0.2f, 0.4f, 0.6f});  // what is marked stays visible
  EXPECT_THROW(draw_points(picture, {{"p1", 400, 100}}), InputError);

  LobeFigure figure;
  figure.panels = {{"one", frame_colour(0), picture}};
  const SpherePanel sphere{"p1", draw_lobe(first_bands(1.0f), y0, 64), "E"};
  EXPECT_THROW(lobe_figure(figure), InputError);
  figure.spheres = {sphere, sphere};
  const Image single = lobe_figure(figure);
  EXPECT_GE(single.width(), 400);
  EXPECT_GE(single.height(), 264);
  figure.panels.push_back({"two", frame_colour(0), picture});
  EXPECT_GE(lobe_figure(figure).height(), single.height() + 200);
}

}  // namespace
}  // namespace occlab
