#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "harness/metrics/colour.h"
#include "harness/verify/sharma_pairs.h"

namespace occlab {
namespace {

std::string name_of(const SharmaPair& pair) {
  return "pair " + std::to_string(&pair - sharma_pairs.data() + 1);
}

TEST(Ciede2000, AllPublishedPairsInBothOrders) {
  for (const SharmaPair& p : sharma_pairs) {
    // The table has four decimals.
    EXPECT_NEAR(ciede2000(p.first, p.second), p.difference, 5e-5) << name_of(p);
    EXPECT_NEAR(ciede2000(p.second, p.first), p.difference, 5e-5) << name_of(p);
  }
}

TEST(Ciede2000, EqualColoursDoNotDiffer) {
  for (const SharmaPair& p : sharma_pairs) {
    EXPECT_EQ(ciede2000(p.first, p.first), 0.0) << name_of(p);
    EXPECT_EQ(ciede2000(p.second, p.second), 0.0) << name_of(p);
  }
}

TEST(Ciede2000, ZeroChromaHasNoHueDifference) {
  // Between two greys only lightness is left: S_L = 1 + 0.015 * 0 / sqrt(20) at a mean L* of 50.
  EXPECT_NEAR(ciede2000({45.0, 0.0, 0.0}, {55.0, 0.0, 0.0}), 10.0, 1e-12);
  // Grey against colour of equal lightness: G = 0.5 (1 - sqrt(5^7 / (5^7 + 25^7))), and only
  // chroma.
  const double g = 0.5 * (1.0 - std::sqrt(1.0 / (1.0 + std::pow(5.0, 7.0))));
  const double c = (1.0 + g) * 10.0;
  EXPECT_NEAR(ciede2000({50.0, 0.0, 0.0}, {50.0, -10.0, 0.0}), c / (1.0 + 0.045 * 0.5 * c), 1e-12);
}

TEST(Colour, SrgbEncoding) {
  EXPECT_EQ(srgb_encode(0.0), 0.0);
  EXPECT_NEAR(srgb_encode(1.0), 1.0, 1e-15);
  EXPECT_NEAR(srgb_encode(0.002), 0.02584, 1e-12);
  EXPECT_NEAR(srgb_encode(0.5), 0.735356983052449, 1e-12);
  EXPECT_NEAR(srgb_encode(0.18), 0.461356129500442, 1e-12);
  EXPECT_NEAR(srgb_encode(0.5f), 0.735356983052449, 1e-7);
  EXPECT_NEAR(srgb_encode(0.0031308), srgb_encode(0.00313081), 1e-6);
}

TEST(Colour, LabOfThePrimaries) {
  struct Known {
    Rgb rgb;
    Lab lab;
  };
  // Published for sRGB's seven-digit matrix; the standard's four digits agree within 0.03.
  const std::vector<Known> known = {
      {{1, 0, 0}, {53.2408, 80.0925, 67.2032}},   {{0, 1, 0}, {87.7347, -86.1827, 83.1793}},
      {{0, 0, 1}, {32.2970, 79.1875, -107.8602}}, {{1, 1, 0}, {97.1393, -21.5537, 94.4780}},
      {{0, 1, 1}, {91.1132, -48.0875, -14.1312}},
  };
  for (const Known& k : known) {
    const Lab lab = xyz_to_lab(rgb_to_xyz(k.rgb));
    EXPECT_NEAR(lab.l, k.lab.l, 0.03);
    EXPECT_NEAR(lab.a, k.lab.a, 0.03);
    EXPECT_NEAR(lab.b, k.lab.b, 0.03);
  }
}

TEST(Colour, GreysHaveNoChroma) {
  for (const double grey : {1e-4, 0.01, 0.18, 1.0}) {
    const Lab lab = xyz_to_lab(rgb_to_xyz({grey, grey, grey}));
    EXPECT_NEAR(chroma(lab), 0.0, 1e-12) << grey;
  }
  EXPECT_NEAR(xyz_to_lab(rgb_to_xyz({1, 1, 1})).l, 100.0, 1e-12);
  EXPECT_NEAR(xyz_to_lab(rgb_to_xyz({0.18, 0.18, 0.18})).l, 49.4961, 1e-4);
  EXPECT_NEAR(xyz_to_lab(rgb_to_xyz({0, 0, 0})).l, 0.0, 1e-12);
}

TEST(Colour, ChromaticityOfWhiteAndPrimaries) {
  const Chromaticity white = xyz_to_uv(rgb_to_xyz({1, 1, 1}));
  EXPECT_NEAR(white.u, 0.1978, 1e-4);
  EXPECT_NEAR(white.v, 0.4683, 1e-4);
  const Chromaticity red = xyz_to_uv(rgb_to_xyz({7, 0, 0}));
  EXPECT_NEAR(red.u, 0.4507, 1e-4);
  EXPECT_NEAR(red.v, 0.5229, 1e-4);
  const Chromaticity blue = xyz_to_uv(rgb_to_xyz({0, 0, 0.1}));
  EXPECT_NEAR(blue.u, 0.1754, 1e-4);
  EXPECT_NEAR(blue.v, 0.1579, 1e-4);
}

TEST(Colour, HueDifferenceIsAnUnsignedAngle) {
  EXPECT_NEAR(hue_difference_degrees({50, 3, 0}, {20, 0, 7}), 90.0, 1e-12);
  EXPECT_NEAR(hue_difference_degrees({50, 0, 7}, {20, 3, 0}), 90.0, 1e-12);
  EXPECT_NEAR(hue_difference_degrees({50, 3, 0}, {20, -1, 0}), 180.0, 1e-12);
  EXPECT_NEAR(hue_difference_degrees({50, 1, -0.1}, {50, 1, 0.1}),
              2.0 * std::atan(0.1) * 180.0 / std::acos(-1.0), 1e-12);
  EXPECT_EQ(hue_difference_degrees({50, 3, 4}, {70, 6, 8}), 0.0);
}

}  // namespace
}  // namespace occlab
